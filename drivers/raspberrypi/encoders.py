"""Encoders on pins: with two channels (`Quadrature`), and with one (`Pulses`)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from threading import Lock
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Protocol

from pydantic import Field

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.pins import stop_edge_detection, translate_pin_errors
from robotcore.description import EncoderDescription, RobotDescription, StrictModel
from robotcore.errors import DeviceError
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Device, Encoder
from robotcore.hardware import Connection, DeviceDriver, Host, motor_of
from robotcore.simulation.sampling import SampleCache

if TYPE_CHECKING:
    from gpiozero import Factory, Pin


LEVELS = (
    "Fed with 3.3 V, its outputs fit the pins. One that needs 5 V drives its outputs to 5 V: then each needs a "
    "divider, 1 kΩ and 2 kΩ to ground."
)
"""What whoever connects an encoder must know."""


class EncoderSettings(StrictModel):
    """What a count is, and the electrics of the lines.

    ``counts`` says what the description's ``counts_per_turn`` counts, on a turn of the wheel, gear included: "cycles"
    of one channel (a data sheet's PPR, a disc's slots), of which every edge is used, or those "edges" themselves
    (often called CPR). ``pull_up`` connects the Pi's resistors, which outputs need that only pull low; ``bounce_s`` is
    how long a level has to hold, for contacts.
    """

    edges_per_cycle: ClassVar[int]

    counts: Literal["cycles", "edges"] = "cycles"
    pull_up: bool = True
    bounce_s: Annotated[float, Field(gt=0, le=0.01)] | None = None

    def edges_per_turn(self, description: EncoderDescription) -> int:
        """Return how many edges a turn of the wheel has, on all channels together."""
        return description.counts_per_turn * (self.edges_per_cycle if self.counts == "cycles" else 1)


class Counter(Protocol):
    """Counts edges, forward up and backward down, as its channels report them."""

    @property
    def edges(self) -> int:
        """The edges counted by now."""


class PinEncoder(Encoder):
    """Tells the edges counted by now as an angle: true whenever it is read.

    It cannot tell a wheel that stands from an encoder that is unplugged: both count nothing. A motor that is controlled
    by it reads it in a thread of its own.
    """

    def __init__(self, name: str, clock: Clock, counter: Counter, edges_per_turn: int, opened: ExitStack) -> None:
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


def open_input(device: str, number: int, settings: EncoderSettings, pins: Factory, opened: ExitStack) -> Pin:
    """Return an open input of a device; raises DeviceError."""
    from gpiozero import InputDevice

    pull = {"pull_up": True} if settings.pull_up else {"pull_up": None, "active_state": True}
    with translate_pin_errors(device, (number,)):
        line = opened.enter_context(InputDevice(number, pin_factory=pins, **pull))
        line.pin.bounce = settings.bounce_s
        line.pin.edges = "both"
    return line.pin


def watch(device: str, pin: Pin, changed: Callable[[float, int], None], opened: ExitStack) -> None:
    """Have a bound method told of every edge, with the tick and the level; its object has to be kept."""
    with translate_pin_errors(device, (int(pin.info.name.removeprefix("GPIO")),)):
        opened.callback(stop_edge_detection, pin)
        pin.when_changed = changed


class QuadratureSettings(EncoderSettings):
    """``a`` leads ``b`` where the wheel turns forward; where it counts the wrong way, swap the two."""

    edges_per_cycle: ClassVar[int] = 4

    a: Gpio
    b: Gpio


class Quadrature(DeviceDriver[EncoderDescription, QuadratureSettings]):
    """Counts all four edges of a cycle.

    gpiozero's RotaryEncoder is made for knobs with detents: it counts whole cycles, and loses one with each edge that
    it misses. A wheel that is to be controlled wants every edge, and no more lost than has to be.
    """

    name = "quadrature"
    summary = "a wheel's encoder with two channels on GPIOs"
    described = EncoderDescription
    settings = QuadratureSettings
    modules = ("gpiozero",)
    supply = ("3.3 V", "ground")
    remedy = "pip install 'robotcore[pi]'"

    def connections(self, settings: QuadratureSettings) -> Sequence[Connection]:
        return gpio("a", settings.a), gpio("b", settings.b)

    def notes(self, description: EncoderDescription, settings: QuadratureSettings) -> Sequence[str]:
        return (LEVELS,)

    def open(self, description: EncoderDescription, settings: QuadratureSettings, host: Host) -> Encoder:
        with ExitStack() as opened:
            a = open_input(description.name, settings.a, settings, host.pins, opened)
            b = open_input(description.name, settings.b, settings, host.pins, opened)
            decoder = QuadratureDecoder(a=bool(a.state), b=bool(b.state))
            watch(description.name, a, decoder.a_changed, opened)
            watch(description.name, b, decoder.b_changed, opened)
            return PinEncoder(
                description.name, host.clock, decoder, settings.edges_per_turn(description), opened.pop_all()
            )


class QuadratureDecoder:
    """Counts the edges of two channels: up where ``a`` leads, down where ``b`` does.

    It goes by levels, not by edges: one that is missed costs as many as it hid, at most a cycle, and what comes
    after it counts as it should.

    >>> decoder = QuadratureDecoder(a=False, b=False)
    >>> decoder.a_changed(0.0, 1)
    >>> decoder.b_changed(0.1, 1)
    >>> decoder.edges
    2
    """

    def __init__(self, *, a: bool, b: bool) -> None:
        self.edges = 0
        self._phase = a << 1 | b

    def a_changed(self, _tick: float, level: int) -> None:
        """Take channel ``a``'s new level, 0 or 1."""
        self._turn(level << 1 | self._phase & 0b01)

    def b_changed(self, _tick: float, level: int) -> None:
        """Take channel ``b``'s new level, 0 or 1."""
        self._turn(self._phase & 0b10 | level)

    def _turn(self, phase: int) -> None:
        if phase != self._phase:
            self.edges += 1 if _NEXT[self._phase] == phase else -1
            self._phase = phase


_NEXT = (0b10, 0b00, 0b11, 0b01)
"""The phase that follows each, forward: (a, b) goes 00, 10, 11, 01."""


class PulsesSettings(EncoderSettings):
    """``gpio`` is the one channel; its rising and falling edges both count."""

    edges_per_cycle: ClassVar[int] = 2

    gpio: Gpio


class Pulses(DeviceDriver[EncoderDescription, PulsesSettings]):
    """Counts edges in the direction in which the wheel's motor was last told to turn.

    So it is right while the motor turns the wheel, and while the wheel coasts on after a stop; it is wrong where the
    wheel is pushed, rolls down a slope, or still coasts one way when it is told to turn the other. A `quadrature`
    encoder is never wrong about that.
    """

    name = "pulses"
    summary = "a wheel's encoder with one channel on a GPIO; its motor tells the direction"
    described = EncoderDescription
    settings = PulsesSettings
    aliases = ("slotted", "light-barrier")
    modules = ("gpiozero",)
    supply = ("3.3 V", "ground")
    remedy = "pip install 'robotcore[pi]'"

    def connections(self, settings: PulsesSettings) -> Sequence[Connection]:
        return (gpio("gpio", settings.gpio),)

    def notes(self, description: EncoderDescription, settings: PulsesSettings) -> Sequence[str]:
        return (LEVELS,)

    def check(self, description: EncoderDescription, settings: PulsesSettings, robot: RobotDescription) -> None:
        if motor_of(description.name, robot) is None:
            raise ValueError(
                f"{description.name} is on no wheel of the drive, so no motor tells its direction; name it in [drive], "
                "or take a quadrature encoder"
            )

    def check_beside(
        self,
        description: EncoderDescription,
        settings: PulsesSettings,
        robot: RobotDescription,
        drivers: Mapping[str, DeviceDriver[Any, Any]],
    ) -> None:
        motor = motor_of(description.name, robot) or ""
        if motor in drivers and not drivers[motor].reports_direction:
            raise ValueError(
                f"the driver of {motor}, {drivers[motor].name!r}, tells no direction, and {description.name} has "
                "none of its own; take a quadrature encoder for that wheel"
            )

    def open(self, description: EncoderDescription, settings: PulsesSettings, host: Host) -> Encoder:
        counter = PulseCounter(description.name, motor_of(description.name, host.robot) or "", host.opened)
        with ExitStack() as opened:
            pin = open_input(description.name, settings.gpio, settings, host.pins, opened)
            watch(description.name, pin, counter.changed, opened)
            return PinEncoder(
                description.name, host.clock, counter, settings.edges_per_turn(description), opened.pop_all()
            )


class PulseCounter:
    """Counts the edges of one channel in the direction of a motor, looked up among the devices opened by then.

    Motors are opened after encoders. One that is not opened turns no wheel: what turns it then is counted as forward.
    """

    def __init__(self, encoder: str, motor: str, opened: Mapping[str, Device]) -> None:
        self._encoder, self._motor, self._opened = encoder, motor, opened
        self._edges = 0

    @property
    def edges(self) -> int:
        """The edges counted; raises DeviceError where the motor is one that tells no direction."""
        motor = self._opened.get(self._motor)
        if motor and not hasattr(motor, "direction"):
            raise DeviceError(
                self._encoder,
                f"the driver of {self._motor} tells no direction. Take a quadrature encoder for its wheel",
                kind="no-direction",
            )
        return self._edges

    def changed(self, _tick: float, _level: int) -> None:
        """Take an edge."""
        self._edges += getattr(self._opened.get(self._motor), "direction", 1)
