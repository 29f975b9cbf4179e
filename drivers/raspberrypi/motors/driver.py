"""The base classes of the drivers of motors on GPIOs, and of their outputs."""

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


def open_pwm_output(device: str, number: int, frequency_hz: int, pins: Factory, opened: ExitStack) -> PWMOutputDevice:
    """Open a GPIO with PWM, and return it; raises DeviceError. Its ``value`` is the duty from 0 to 1, at first 0.

    device: the motor's name, for errors.
    number: the GPIO.
    opened: the stack whose `close` frees the GPIO and pulls it down.
    """
    from gpiozero import PWMOutputDevice

    with translate_pin_errors(device, (number,)):
        output = PWMOutputDevice(number, frequency=frequency_hz, pin_factory=pins)
        opened.callback(_pull_down, device, number, pins)
        return opened.enter_context(output)


def open_digital_output(
    device: str, number: int, pins: Factory, opened: ExitStack, *, is_high: bool
) -> DigitalOutputDevice:
    """Open a GPIO that is high or low, and return it; raises DeviceError.

    The other parameters are those of `open_pwm_output`.

    is_high: the first level.
    """
    from gpiozero import DigitalOutputDevice

    with translate_pin_errors(device, (number,)):
        output = DigitalOutputDevice(number, initial_value=is_high, pin_factory=pins)
        opened.callback(_pull_down, device, number, pins)
        return opened.enter_context(output)


def _pull_down(device: str, number: int, pins: Factory) -> None:
    # gpiozero leaves a closed GPIO floating until the Pi starts again. A board without resistors, such as an L298N's,
    # reads a floating input as high or as noise.
    from gpiozero import PinFixedPull

    with (
        translate_pin_errors(device, (number,)),
        suppress(PinFixedPull),
    ):  # GPIO 2 and 3 have resistors to 3.3 V on the Pi
        pins.pin(number).pull = "down"


def set_low(output: PWMOutputDevice) -> None:
    """Set a PWM output low at once. Its PWM works again with the next duty.

    The duty 0 alone is not sufficient, because lgpio sets the line low only at the next step of the PWM cycle. If the
    process is suspended before that step, the line stays high.
    """
    if not output.value:  # the output is low
        output.off()
        return
    frequency = output.frequency
    output.frequency = None
    try:
        output.off()
    finally:
        output.frequency = frequency  # without a frequency, any duty above 0 is full duty


class Bridge(Output):
    """The output to one motor by GPIOs. A subclass sets their levels.

    motor: the motor's name, for errors.
    gpios: the GPIOs of the motor, for errors.
    opened: the stack whose `close` frees the GPIOs.
    """

    def __init__(self, motor: str, gpios: Sequence[int], opened: ExitStack) -> None:
        self.motor, self.gpios, self._opened = motor, gpios, opened

    @abstractmethod
    def set_duty(self, duty: float) -> None:
        """Set the levels of all lines for a duty from -1 to 1.

        At duty 0, every line is set low, even if an error occurs at another line.
        """

    def turn(self, duty: float) -> None:
        try:
            self.set_duty(round_to_percent(duty))
        except Exception as error:
            raise build_pin_error(self.motor, self.gpios, error) from error

    def close(self) -> None:
        """Close every line, even if an error occurs at another line."""
        with translate_pin_errors(self.motor, self.gpios):
            self._opened.close()


def round_to_percent(duty: float) -> float:
    """Return a duty rounded to whole percent, the resolution of lgpio.

    lgpio computes ``int(duty * 100)``. So the result is slightly larger where a float would be rounded down.

    >>> int(0.29 * 100), int(round_to_percent(0.29) * 100)
    (28, 29)
    """
    return _PERCENT[round(abs(duty) * 100)] if duty >= 0 else -_PERCENT[round(abs(duty) * 100)]


_PERCENT = tuple(
    percent / 100 if int(percent / 100 * 100) == percent else math.nextafter(percent / 100, 1) for percent in range(101)
)


BATTERY = (
    "The motors need a battery of their own. A pad of the header gives too little current, and the motors disturb it. "
    "Join the grounds of the battery, the motor board and the Pi."
)
PULLED_DOWN = (
    "A resistor of 10 kΩ from GPIO {line} (standby) to ground keeps the motors off while the Pi starts, and if no "
    "program drives that line. Remove a pull-up of that line on the motor board."
)
UNGUARDED = (
    "There is no standby line. If the kernel keeps the levels of outputs (see robotcore doctor), motors may continue "
    "to turn after the program and its guardian were killed. STBY, nSLEEP, or an L298N's joined ENA and ENB (jumpers "
    "off) can be the standby line: set standby = GPIO in place of enable."
)
RISING = (
    "GPIO 0 to 8 are pulled up from power-on until a program uses them, and {lines} may turn this motor during that "
    "time. Use GPIO 9 to 27, resistors of 10 kΩ to ground, or a standby line."
)
"""The warning that `robotcore wiring` prints for a motor on GPIO 0 to 8."""

MAX_SILENCE_S = 0.25
"""The time for which the guardian does not kill a silent app, in seconds. The app may be swapping, collecting garbage,
or waiting for a slow SD card."""


class MotorSettings(StrictModel):
    """The settings that all motors on pins share."""

    standby: Gpio | None = None
    """The GPIO of the board's standby input (TB6612: STBY, DRV8833: nSLEEP). Several motors may share it.

    The guardian's process claims this GPIO, and holds it high during a run. So the motors also stop if the guardian
    ends.
    """

    frequency_hz: Annotated[int, Field(ge=10, le=10_000)] = 100
    """The frequency of the PWM in Hz."""

    model: Model
    """The velocity of the wheel at each duty."""

    control: Control | None = None
    """The settings of velocity control by the wheel's encoder. If it is None, the model alone gives the duty."""


SettingsT = TypeVar("SettingsT", bound=MotorSettings)


class MotorDriver(DeviceDriver[MotorDescription, SettingsT], Generic[SettingsT]):
    """The base class of the drivers of motors on GPIOs. A subclass defines the lines.

    A new duty takes effect with the next cycle of lgpio's software PWM, up to ``1 / frequency_hz`` seconds later. A
    stop takes effect at once.
    """

    described = MotorDescription
    modules = ("gpiozero",)
    supply = ("ground",)
    remedy = "pip install 'robotcore[pi]'"
    reports_direction = True

    @abstractmethod
    def wires(self, settings: SettingsT) -> Sequence[Connection]:
        """Return the connections to the motor's own GPIOs, without standby. The motor stands if all of them are low."""

    def find_turning_lines(self, settings: SettingsT) -> tuple[int, ...]:
        """Return those of the motor's own GPIOs that may turn the motor if they are high."""
        return self._gpios(settings)

    @abstractmethod
    def open_bridge(self, name: str, settings: SettingsT, host: Host) -> Bridge:
        """Open the motor's own GPIOs, and return its output; raises DeviceError.

        All lines are low at first, except a line that only enables the board.
        """

    def connections(self, settings: SettingsT) -> Sequence[Connection]:
        wires = self.wires(settings)
        return wires if settings.standby is None else (*wires, gpio("standby", settings.standby, is_shared=True))

    def notes(self, description: MotorDescription, settings: SettingsT) -> Sequence[str]:
        return (BATTERY, UNGUARDED if settings.standby is None else PULLED_DOWN.format(line=settings.standby))

    def warnings(self, settings: SettingsT) -> Sequence[str]:
        lines = [line for line in self._find_enabling_lines(settings) if line in PULLED_UP]
        return (RISING.format(lines=f"GPIO {', '.join(map(str, lines))}"),) if lines else ()

    def check(self, description: MotorDescription, settings: SettingsT, robot: RobotDescription) -> None:
        if held := [line for line in self._find_enabling_lines(settings) if line in HELD_UP]:
            raise ValueError(
                f"GPIO {held[0]} is held high by a resistor on the Pi, so {description.name} may turn while no program "
                "runs; use another GPIO, best of 9 to 27"
            )
        require_drivable(description, settings.model, settings.control, robot)
        if settings.control:
            _require_whole_cycles(settings.control, settings.frequency_hz)

    def open(self, description: MotorDescription, settings: SettingsT, host: Host) -> Motor:
        bridge = partial(self.open_bridge, description.name, settings, host)
        return open_motor(description, settings.model, settings.control, bridge, host)

    def cutoffs(self, description: MotorDescription, settings: SettingsT, host: Host) -> Sequence[CutoffSpec]:
        from gpiozero.pins.mock import MockFactory

        if isinstance(host.pins, MockFactory):  # no other process sees these pins
            return ()
        if settings.standby is not None:
            return (CutoffSpec(description.name, "drivers.raspberrypi.cutoff:StandbyLine", {"line": settings.standby}),)
        lines = {"lines": list(self._gpios(settings)), "owner": host.owner}
        return (CutoffSpec(description.name, "drivers.raspberrypi.cutoff:MotorLines", lines, MAX_SILENCE_S),)

    def _find_enabling_lines(self, settings: SettingsT) -> tuple[int, ...]:
        return self.find_turning_lines(settings) if settings.standby is None else (settings.standby,)

    def _gpios(self, settings: SettingsT) -> tuple[int, ...]:
        return tuple(int(wire.where) for wire in self.wires(settings))


def _require_whole_cycles(control: Control, frequency_hz: int) -> None:
    if control.period_s * frequency_hz < 1:
        raise ValueError(
            f"control.period_s {control.period_s:g} is shorter than a cycle of {frequency_hz} Hz; lengthen it, or "
            "raise frequency_hz"
        )
