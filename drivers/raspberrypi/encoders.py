"""The drivers of encoders on GPIOs: with two channels (`Quadrature`), and with one channel (`Pulses`)."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from threading import Lock
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.pins import stop_edge_detection, translate_pin_errors
from robotcore.description import RobotDescription
from robotcore.hal.clock import Clock
from robotcore.hal.device import Device
from robotcore.hal.device_test import REVERSED
from robotcore.hal.sampling import SampleCache
from robotcore.hardware import Connection, DeviceContext, DeviceDriver, Drivers, motor_of
from robotcore.kinds.encoder import Angle, Encoder, EncoderDescription

if TYPE_CHECKING:
    from gpiozero import InputDevice


LEVELS = (
    "Supply the encoder with 3.3 V: then its outputs fit the pins. An encoder that needs 5 V drives its outputs to "
    "5 V, and each output needs a divider, 1 kΩ and 2 kΩ to ground."
)
"""The note that `robotcore wiring` prints for each encoder."""


class EdgeCounter:
    """Counts the edges of an encoder: up if the wheel turns forward, and down if it turns backward."""

    edges: int = 0
    """The number of forward edges minus the number of backward edges."""


class PinEncoder(Encoder):
    """An encoder on GPIOs, which converts counted edges to the angle of the wheel. Any thread may read it.

    An unplugged encoder has no edges, so it cannot be distinguished from a wheel at rest.
    """

    def __init__(self, name: str, clock: Clock, counter: EdgeCounter, edges_per_turn: int, opened: ExitStack) -> None:
        super().__init__(name)
        self._counter, self._opened = counter, opened
        self._edge_rad = math.tau / edges_per_turn
        self._newest_at = SampleCache(clock, self._take)
        self._lock = Lock()

    def _newest(self) -> Angle:
        with self._lock:
            return self._newest_at()

    def _take(self, time: float, sequence: int) -> Angle:
        return Angle(self._counter.edges * self._edge_rad, time, sequence)

    def _release(self) -> None:
        self._opened.close()


OnEdge = Callable[[float, int], None]
"""A function that receives the tick and the level, 0 or 1, of each edge."""


class EncoderDriver(DeviceDriver):
    """The base class of the drivers of encoders on GPIOs."""

    described = EncoderDescription
    modules = ("gpiozero",)
    connector = "GPIO"
    supply = ("3.3 V", "ground")
    remedy = "pip install 'robotcore[pi]'"
    edges_per_cycle: ClassVar[int]

    counts: Literal["cycles", "edges"] = "cycles"
    """The unit of ``counts_per_turn`` in the robot's description.

    "cycles" are the cycles of one channel: the PPR of a data sheet, or the slots of a disc. "edges" are the edges of
    all channels, often called CPR. A turn is a turn of the wheel, not of the motor in front of a gear.
    """

    pull_up: bool = True
    """Whether the Pi's pull-up resistors are connected, which open-collector outputs need."""

    bounce_s: Annotated[float, Field(gt=0, le=0.01)] | None = None
    """The debounce time of mechanical contacts, in seconds. A shorter change of a level is ignored."""

    def edges_per_turn(self, description: EncoderDescription) -> int:
        """Return the number of edges of all channels in a turn of the wheel."""
        return description.counts_per_turn * (self.edges_per_cycle if self.counts == "cycles" else 1)

    def notes(self, description: EncoderDescription) -> Sequence[str]:
        return (LEVELS,)

    def open(self, description: EncoderDescription, context: DeviceContext) -> Encoder:
        from gpiozero import InputDevice

        pull = {"pull_up": True} if self.pull_up else {"pull_up": None, "active_state": True}
        numbers = [int(wire.where) for wire in self.connections()]
        inputs = []
        with ExitStack() as opened:
            for number in numbers:
                with translate_pin_errors(description.name, (number,)):
                    inputs.append(opened.enter_context(InputDevice(number, pin_factory=context.pins, **pull)))
                    inputs[-1].pin.bounce = self.bounce_s
                    inputs[-1].pin.edges = "both"
            counter, callbacks = self.build_counter(description, inputs, context)
            for number, line, on_edge in zip(numbers, inputs, callbacks, strict=True):
                with translate_pin_errors(description.name, (number,)):
                    opened.callback(stop_edge_detection, line.pin)
                    line.pin.when_changed = on_edge  # gpiozero has only a weak reference to the counter
            edges_per_turn = self.edges_per_turn(description)
            return PinEncoder(description.name, context.clock, counter, edges_per_turn, opened.pop_all())

    @abstractmethod
    def build_counter(
        self, description: EncoderDescription, inputs: Sequence[InputDevice], context: DeviceContext
    ) -> tuple[EdgeCounter, Sequence[OnEdge]]:
        """Return a counter, and its functions for the edges of each input."""


class Quadrature(EncoderDriver):
    """Opens encoders with two channels. If one counts the wrong way, swap its two GPIOs.

    All four edges of a cycle are counted. It does not use gpiozero's RotaryEncoder, which is made for knobs with
    detents and counts only whole cycles. The velocity control of a wheel needs every edge.
    """

    name = "quadrature"
    summary = "a wheel's encoder with two channels on GPIOs"
    edges_per_cycle = 4

    a: Gpio
    """The GPIO of the channel that leads if the wheel turns forward."""

    b: Gpio

    def connections(self) -> Sequence[Connection]:
        return gpio("a", self.a), gpio("b", self.b)

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        return {"a": self.b, "b": self.a} if mistake == REVERSED else None

    def build_counter(
        self, description: EncoderDescription, inputs: Sequence[InputDevice], context: DeviceContext
    ) -> tuple[QuadratureDecoder, Sequence[OnEdge]]:
        a, b = (bool(line.pin.state) for line in inputs)
        decoder = QuadratureDecoder(a=a, b=b)
        return decoder, (decoder.on_edge_a, decoder.on_edge_b)


class QuadratureDecoder(EdgeCounter):
    """Counts the edges of two channels: up if ``a`` leads, down if ``b`` leads.

    It compares the levels before and after each edge. So the error after a missed edge is at most one cycle, and later
    edges are counted correctly.

    >>> decoder = QuadratureDecoder(a=False, b=False)
    >>> decoder.on_edge_a(0.0, 1)
    >>> decoder.on_edge_b(0.1, 1)
    >>> decoder.edges
    2
    """

    def __init__(self, *, a: bool, b: bool) -> None:
        self._phase = a << 1 | b

    def on_edge_a(self, _tick: float, level: int) -> None:
        """Count an edge of channel ``a``. ``level`` is 0 or 1."""
        self._advance(level << 1 | self._phase & 0b01)

    def on_edge_b(self, _tick: float, level: int) -> None:
        """Count an edge of channel ``b``. ``level`` is 0 or 1."""
        self._advance(self._phase & 0b10 | level)

    def _advance(self, phase: int) -> None:
        if phase != self._phase:
            self.edges += 1 if _NEXT[self._phase] == phase else -1
            self._phase = phase


_NEXT = (0b10, 0b00, 0b11, 0b01)
"""The next phase on a forward turn, by the present phase. The bits of a phase are the levels of a and b: 00, 10, 11,
01."""


class Pulses(EncoderDriver):
    """Opens encoders with one channel, which count in the direction of the last command to the wheel's motor.

    The count is right while the motor turns the wheel, and while the wheel coasts after a stop. The count is wrong if
    the wheel is pushed, rolls down a slope, or coasts on after a command to turn the other way. An encoder with two
    channels counts correctly in all these cases.
    """

    name = "pulses"
    summary = "a wheel's encoder with one channel on a GPIO; the motor's command gives the direction"
    aliases = ("slotted", "light-barrier")
    edges_per_cycle = 2
    has_own_direction = False

    gpio: Gpio
    """The GPIO of the channel, whose rising and falling edges are counted."""

    def connections(self) -> Sequence[Connection]:
        return (gpio("gpio", self.gpio),)

    def check(self, description: EncoderDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if (motor := motor_of(description.name, robot)) is None:
            raise ValueError(
                f"{description.name} is on no wheel of the drive, so no motor gives its direction; name it in [drive], "
                "or use a quadrature encoder"
            )
        if motor in drivers and not drivers[motor].reports_direction:
            raise ValueError(
                f"the driver of {motor}, {drivers[motor].name!r}, reports no direction, and "
                f"{description.name} needs one; use a quadrature encoder for that wheel"
            )

    def build_counter(
        self, description: EncoderDescription, inputs: Sequence[InputDevice], context: DeviceContext
    ) -> tuple[PulseCounter, Sequence[OnEdge]]:
        counter = PulseCounter(motor_of(description.name, context.robot) or "", context.opened)
        return counter, (counter.on_edge,)


class PulseCounter(EdgeCounter):
    """Counts the edges of one channel in the direction of a motor.

    Motors are opened after encoders. So the motor is looked up at each edge, and edges before its opening count as
    forward.

    motor: the name of the motor.
    opened: the open devices of the robot by name.
    """

    def __init__(self, motor: str, opened: Mapping[str, Device]) -> None:
        self._motor, self._opened = motor, opened

    def on_edge(self, _tick: float, _level: int) -> None:
        """Count an edge in the motor's present direction."""
        self.edges += getattr(self._opened.get(self._motor), "direction", 1)
