"""The base of the drivers of motors on pins: output lines, bridges, settings, checks and cutoffs."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from functools import partial
from typing import TYPE_CHECKING, Annotated, Generic, TypeVar

from pydantic import Field

from drivers.raspberrypi.header import HELD_UP, PULLED_UP, Gpio, gpio
from drivers.raspberrypi.pins import build_pin_error, translate_pin_errors
from robotcore.description import MotorDescription, RobotDescription, StrictModel
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Motor
from robotcore.hardware import Connection, DeviceDriver, Host
from robotcore.hardware.motor_control import Control, open_motor, require_drivable
from robotcore.hardware.motor_model import Model, Output

if TYPE_CHECKING:
    from gpiozero import DigitalOutputDevice, Factory, PWMOutputDevice


def pwm_output(device: str, number: int, frequency_hz: int, pins: Factory, opened: ExitStack) -> PWMOutputDevice:
    """Return a line whose ``value`` is a duty from 0 to 1, low by now; raises DeviceError."""
    from gpiozero import PWMOutputDevice

    with translate_pin_errors(device, (number,)):
        output = PWMOutputDevice(number, frequency=frequency_hz, pin_factory=pins)
        opened.callback(_pull_down, device, number, pins)
        return opened.enter_context(output)


def digital_output(device: str, number: int, pins: Factory, opened: ExitStack, *, is_high: bool) -> DigitalOutputDevice:
    """Return a line that is high or low; raises DeviceError."""
    from gpiozero import DigitalOutputDevice

    with translate_pin_errors(device, (number,)):
        output = DigitalOutputDevice(number, initial_value=is_high, pin_factory=pins)
        opened.callback(_pull_down, device, number, pins)
        return opened.enter_context(output)


def _pull_down(device: str, number: int, pins: Factory) -> None:
    """Pull a line down that is closed: gpiozero leaves it floating until the Pi is started again.

    A board without resistors of its own, such as one with an L298N, takes a floating input for high or for noise.
    """
    from gpiozero import PinFixedPull

    with (
        translate_pin_errors(device, (number,)),
        suppress(PinFixedPull),
    ):  # GPIO 2 and 3 have resistors to 3.3 V on the Pi
        pins.pin(number).pull = "down"


def set_low(output: PWMOutputDevice) -> None:
    """Make a line low at once, its PWM ready for the next duty.

    lgpio lets a line of duty 0 fall in the course of its cycle: in a process that is suspended before, it stays high.
    """
    if not output.value:  # it has fallen, or was never high
        output.off()
        return
    frequency = output.frequency
    output.frequency = None
    try:
        output.off()
    finally:
        output.frequency = frequency  # without one, any duty above 0 would be all of it


class Bridge(Output):
    """These GPIOs of a motor, and how to let go of them."""

    def __init__(self, motor: str, gpios: Sequence[int], opened: ExitStack) -> None:
        self.motor, self.gpios, self._opened = motor, gpios, opened

    @abstractmethod
    def put(self, duty: float) -> None:
        """Put a duty on the lines; at 0 no line's failure keeps another one from going low."""

    def turn(self, duty: float) -> None:
        try:
            self.put(whole_percent(duty))
        except Exception as error:
            raise build_pin_error(self.motor, self.gpios, error) from error

    def close(self) -> None:
        """Let go of each line, even where another one fails."""
        with translate_pin_errors(self.motor, self.gpios):
            self._opened.close()


def whole_percent(duty: float) -> float:
    """Return the nearest duty in whole percent, such that lgpio, which cuts ``int(duty * 100)``, sends just that.

    One percent is the resolution of every motor here, on simulated pins too: of
    ``forward_rad_s / (1 - dead_band)``, so 0.16 rad/s for a wheel of 14 rad/s with a dead band of 0.1.

    >>> int(0.29 * 100), int(whole_percent(0.29) * 100)
    (28, 29)
    """
    return _PERCENT[round(abs(duty) * 100)] if duty >= 0 else -_PERCENT[round(abs(duty) * 100)]


_PERCENT = tuple(
    percent / 100 if int(percent / 100 * 100) == percent else math.nextafter(percent / 100, 1) for percent in range(101)
)


BATTERY = (
    "The motors have a battery of their own, never a pad of the header: it gives them too little, and they disturb it. "
    "Its ground, the motor board's and the Pi's are joined."
)
PULLED_DOWN = (
    "A resistor of 10 kΩ from GPIO {line} (standby) to ground keeps the motors off while the Pi starts, and when "
    "nobody drives that line any more; take off what pulls it up on the motor board."
)
UNGUARDED = (
    "There is no standby line: where the kernel keeps outputs (robotcore doctor tells), motors may go on after the "
    "program and its guardian were killed. STBY, nSLEEP, or an L298N's ENA and ENB joined (jumpers off) can be one: "
    "standby = GPIO, in place of enable."
)
RISING = (
    "GPIO 0 to 8 are pulled up from when the Pi is switched on until a program takes them, and {lines} may turn this "
    "motor then. Take GPIO 9 to 27, resistors of 10 kΩ to ground, or a standby line."
)
"""What whoever connects a motor must know."""

PAUSE_S = 0.25
"""An app that is silent for no longer only swaps, collects garbage or waits for a slow card: it is not ended for it."""


class MotorSettings(StrictModel):
    """A motor's model, the frequency of its PWM, the control by its encoder, and the line that lets its board sleep.

    ``standby`` (TB6612: STBY, DRV8833: nSLEEP) may be shared by motors. No driver claims it: the guardian process holds
    it high while it watches, so that the motors stand when this process is gone, whatever became of its own lines.
    """

    standby: Gpio | None = None
    frequency_hz: Annotated[int, Field(ge=10, le=10_000)] = 100
    model: Model
    control: Control | None = None


SettingsT = TypeVar("SettingsT", bound=MotorSettings)


class MotorDriver(DeviceDriver[MotorDescription, SettingsT], Generic[SettingsT]):
    """Opens a motor on the lines that a subclass knows.

    lgpio makes PWM in software and begins a command with the next cycle: one that is no stop may be late by
    ``1 / frequency_hz``.
    """

    described = MotorDescription
    modules = ("gpiozero",)
    supply = ("ground",)
    remedy = "pip install 'robotcore[pi]'"
    reports_direction = True

    @abstractmethod
    def wires(self, settings: SettingsT) -> Sequence[Connection]:
        """Return the motor's own lines: where all are low, it stands."""

    def turning(self, settings: SettingsT) -> tuple[int, ...]:
        """Return the GPIOs of which one that is high may turn the motor."""
        return self._gpios(settings)

    @abstractmethod
    def bridge(self, name: str, settings: SettingsT, host: Host) -> Bridge:
        """Open the motor's own lines, all of them low but such as only enable; raises DeviceError."""

    def connections(self, settings: SettingsT) -> Sequence[Connection]:
        wires = self.wires(settings)
        return wires if settings.standby is None else (*wires, gpio("standby", settings.standby, is_shared=True))

    def notes(self, description: MotorDescription, settings: SettingsT) -> Sequence[str]:
        return (BATTERY, UNGUARDED if settings.standby is None else PULLED_DOWN.format(line=settings.standby))

    def warnings(self, settings: SettingsT) -> Sequence[str]:
        lines = [line for line in self._enabling(settings) if line in PULLED_UP]
        return (RISING.format(lines=f"GPIO {', '.join(map(str, lines))}"),) if lines else ()

    def check(self, description: MotorDescription, settings: SettingsT, robot: RobotDescription) -> None:
        if held := [line for line in self._enabling(settings) if line in HELD_UP]:
            raise ValueError(
                f"GPIO {held[0]} is held high by a resistor on the Pi, so {description.name} may turn when no program "
                "runs; take another one, best of 9 to 27"
            )
        require_drivable(description, settings.model, settings.control, robot)
        if settings.control:
            _require_whole_cycles(settings.control, settings.frequency_hz)

    def open(self, description: MotorDescription, settings: SettingsT, host: Host) -> Motor:
        bridge = partial(self.bridge, description.name, settings, host)
        return open_motor(description, settings.model, settings.control, bridge, host)

    def cutoffs(self, description: MotorDescription, settings: SettingsT, host: Host) -> Sequence[CutoffSpec]:
        from gpiozero.pins.mock import MockFactory

        if isinstance(host.pins, MockFactory):  # nobody else sees these pins
            return ()
        if settings.standby is not None:
            return (CutoffSpec(description.name, "drivers.raspberrypi.cutoff:StandbyLine", {"line": settings.standby}),)
        lines = {"lines": list(self._gpios(settings)), "owner": host.owner}
        return (CutoffSpec(description.name, "drivers.raspberrypi.cutoff:MotorLines", lines, PAUSE_S),)

    def _enabling(self, settings: SettingsT) -> tuple[int, ...]:
        """Return the lines that must be low where nobody drives them, or the motor may turn: standby alone does it."""
        return self.turning(settings) if settings.standby is None else (settings.standby,)

    def _gpios(self, settings: SettingsT) -> tuple[int, ...]:
        return tuple(int(wire.where) for wire in self.wires(settings))


def _require_whole_cycles(control: Control, frequency_hz: int) -> None:
    if control.period_s * frequency_hz < 1:
        raise ValueError(
            f"control.period_s {control.period_s:g} is shorter than a cycle of {frequency_hz} Hz; lengthen it, or "
            "raise frequency_hz"
        )
