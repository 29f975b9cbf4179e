"""An encoder with one channel: a slotted disc, a single hall sensor. It cannot tell the direction by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from typing import Any, ClassVar

from drivers.raspberrypi.encoders.encoder import LEVELS, EncoderSettings, PinEncoder, open_input, watch
from drivers.raspberrypi.gpio import Gpio, gpio
from robotcore.description import EncoderDescription, RobotDescription
from robotcore.errors import DeviceError
from robotcore.hal.devices import Device, Encoder
from robotcore.hardware import Connection, DeviceDriver, Host, motor_of


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
    parts = ("slotted", "light-barrier")
    modules = ("gpiozero",)
    supply = ("3.3 V", "ground")
    remedy = "pip install 'robotcore[pi]'"

    def connections(self, settings: PulsesSettings) -> Sequence[Connection]:
        return (gpio("gpio", settings.gpio),)

    def notes(self, told: EncoderDescription, settings: PulsesSettings) -> Sequence[str]:
        return (LEVELS,)

    def check(self, told: EncoderDescription, settings: PulsesSettings, robot: RobotDescription) -> None:
        if motor_of(told.name, robot) is None:
            raise ValueError(
                f"{told.name} is on no wheel of the drive, so no motor tells its direction; name it in [drive], or "
                "take a quadrature encoder"
            )

    def check_beside(
        self,
        told: EncoderDescription,
        settings: PulsesSettings,
        robot: RobotDescription,
        drivers: Mapping[str, DeviceDriver[Any, Any]],
    ) -> None:
        motor = motor_of(told.name, robot) or ""
        if motor in drivers and not drivers[motor].tells_direction:
            raise ValueError(
                f"the driver of {motor}, {drivers[motor].name!r}, tells no direction, and {told.name} has none of its "
                "own; take a quadrature encoder for that wheel"
            )

    def open(self, told: EncoderDescription, settings: PulsesSettings, host: Host) -> Encoder:
        counter = PulseCounter(told.name, motor_of(told.name, host.robot) or "", host.opened)
        with ExitStack() as opened:
            pin = open_input(told.name, settings.gpio, settings, host.pins, opened)
            watch(told.name, pin, counter.changed, opened)
            return PinEncoder(told.name, host.clock, counter, settings.edges_per_turn(told), opened.pop_all())


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
            )
        return self._edges

    def changed(self, _tick: float, _level: int) -> None:
        """Take an edge."""
        self._edges += getattr(self._opened.get(self._motor), "direction", 1)
