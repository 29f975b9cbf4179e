"""The drivers of motors on a PCA9685: on H-bridges with two inputs, and on boards with a direction input on a GPIO."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from typing import Annotated, Any

from pydantic import Field, model_validator

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.motors.boards import BATTERY
from drivers.raspberrypi.pins import open_output, translate_pin_errors
from drivers.raspberrypi.pwm.boards import BOARDS, build_motor_settings
from drivers.raspberrypi.pwm.chip import MAX_HZ, MIN_HZ, PwmChip
from drivers.raspberrypi.pwm.settings import SUPPLY, Channel, ChannelDriver, is_virtual
from robotcore.description import RobotDescription
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.device_test import REVERSED
from robotcore.hardware import Connection, DeviceContext, Drivers
from robotcore.hardware.motor_control import Control, open_motor, require_drivable
from robotcore.hardware.motor_model import Model, Output
from robotcore.kinds.motor import Motor, MotorDescription

NO_TIMEOUT_NOTE = (
    "The chip has no time-out: it keeps its outputs if the Pi hangs or restarts. Then only a switch in the motors' "
    "supply stops the motors, or 3.3 V at the chip's input OE."
)
"""The note that `robotcore wiring` prints for a motor."""


class ChannelMotorDriver(ChannelDriver):
    """The base class of the drivers of motors on channels. A subclass defines the channels and their duties."""

    described = MotorDescription
    reports_direction = True

    frequency_hz: Annotated[int, Field(ge=MIN_HZ, le=MAX_HZ)] = 1500
    """The frequency of the PWM in Hz, which all channels of the chip have: 50 if servos are on the same chip."""

    model: Model
    """The velocity of the wheel at each duty."""

    control: Control | None = None
    """The settings of velocity control by the wheel's encoder. If it is None, the model alone gives the duty."""

    @property
    def wanted_hz(self) -> int:
        return self.frequency_hz

    @abstractmethod
    def duties(self, duty: float) -> Mapping[int, float]:
        """Return the duty of each channel at a motor's duty from -1 to 1, in the order in which they are set.

        The motor stands if the last one is off.
        """

    def notes(self, description: MotorDescription) -> Sequence[str]:
        return SUPPLY, BATTERY, NO_TIMEOUT_NOTE

    def check(self, description: MotorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        self.require_one_frequency(drivers)
        require_drivable(description, self.model, self.control, robot)

    def open(self, description: MotorDescription, context: DeviceContext) -> Motor:
        output = partial(self._open_output, description.name, context)
        return open_motor(description, self.model, self.control, output, context)

    def cutoffs(self, description: MotorDescription, context: DeviceContext) -> Sequence[CutoffSpec]:
        if is_virtual(context):  # no other process sees the simulated bus
            return ()
        channels = list(reversed(self.duties(0.0)))
        settings = {"bus": self.bus, "address": self.address, "channels": channels, "owner": context.owner}
        return (CutoffSpec(description.name, "drivers.raspberrypi.pwm.cutoff:ChannelCutoff", settings),)

    def _open_output(self, name: str, context: DeviceContext) -> Output:
        return ChannelOutput(name, self, self.take_chip(name, context))


class ChannelOutput(Output):
    """The channels of one motor. At a stop and before a reversal, each is switched off.

    motor: the motor's name, for errors.
    """

    def __init__(self, motor: str, driver: ChannelMotorDriver, chip: PwmChip) -> None:
        self._motor, self._driver, self._chip = motor, driver, chip
        self._direction = 0

    def turn(self, duty: float) -> None:
        with self._driver.translate_errors(self._motor):
            direction = (duty > 0) - (duty < 0)
            if direction != self._direction or not direction:
                self._direction = 0
                self._switch_off()
                self._set_direction(direction)
                self._direction = direction
            if direction:
                for channel, share in self._driver.duties(duty).items():
                    self._chip.set_duty(channel, share)

    def close(self) -> None:
        """Do nothing: the motor was stopped, and the devices on the chip share it."""

    def _switch_off(self) -> None:
        # The last channel alone stops the motor. If the bus hangs, a try of each would delay the stops of other motors.
        failures = []
        for channel in reversed(tuple(self._driver.duties(0.0))):
            try:
                self._chip.set_duty(channel, 0.0)
            except TimeoutError:  # noqa: PERF203  a failure of one channel must not prevent the others
                raise
            except OSError as failure:
                failures.append(failure)
        if failures:
            raise failures[0]

    def _set_direction(self, direction: int) -> None:
        """Set the signal of the direction that is not on a channel, while the motor is off."""


class HBridgeChannelDriver(ChannelMotorDriver):
    """Opens motors on an H-bridge whose inputs are on channels.

    If a wheel turns the wrong way, swap ``forward`` and ``backward``. The keys ``board`` and ``motor`` give the
    address, the frequency and the channels of a known board. Other keys override them.
    """

    name = "pca9685-motor"
    summary = "a motor on channels of a PCA9685: Adafruit Motor HAT, JetBot, Freenove 4WD"
    aliases = ("pca9685", "motorhat", "motor-hat", "motorkit", "freenove", "jetbot")

    board: str | None = None
    """The name of a board, such as ``adafruit-motor-hat``."""

    motor: str | None = None
    """The motor's place on the board, such as ``M1`` or ``front-left``."""

    forward: Channel
    """The channel of the input that is high if the motor turns forward."""

    backward: Channel
    """The channel of the input that is high if the motor turns backward."""

    pwm: Channel | None = None
    """The channel of the motor's PWM input (TB6612: PWMA or PWMB).

    Without it, the inputs ``forward`` and ``backward`` have the PWM.
    """

    @model_validator(mode="before")
    @classmethod
    def _insert_board(cls, table: Any) -> Any:
        if not isinstance(table, Mapping) or not ({"board", "motor"} & table.keys()):
            return table
        return {**build_motor_settings(table.get("board"), table.get("motor")), **table}

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        return {"forward": self.backward, "backward": self.forward} if mistake == REVERSED else None

    def duties(self, duty: float) -> Mapping[int, float]:
        if self.pwm is None:
            first, last = (self.backward, self.forward) if duty > 0 else (self.forward, self.backward)
            return {first: 0.0, last: abs(duty)}
        return {self.forward: float(duty > 0), self.backward: float(duty < 0), self.pwm: abs(duty)}

    def connections(self) -> Sequence[Connection]:
        signals = {"forward": self.forward, "backward": self.backward, "pwm": self.pwm}
        channels = [self.connect(signal, number) for signal, number in signals.items() if number is not None]
        return (*super().connections(), *channels)

    def notes(self, description: MotorDescription) -> Sequence[str]:
        if self.board is None:
            return super().notes(description)
        board = BOARDS[self.board]
        return f"Connect the motor to {self.motor} of the {board.title}.", board.note, NO_TIMEOUT_NOTE


class PhaseChannelDriver(ChannelMotorDriver):
    """Opens motors on a board with a direction input on a GPIO, and a PWM input on a channel.

    If a wheel turns the wrong way, change ``forward_is_high``, or swap the motor's two wires.
    """

    name = "pca9685-phase-motor"
    summary = "a motor with its PWM on a PCA9685 and its direction on a GPIO: SunFounder PiCar-S and PiCar-V"
    aliases = ("picar", "sunfounder")
    modules = ("gpiozero",)
    connector = "GPIO"
    remedy = "pip install 'robotcore[pi]'"

    pwm: Channel
    """The channel of the motor's PWM input."""

    phase: Gpio
    """The GPIO of the input for the direction."""

    forward_is_high: bool = False
    """Whether the GPIO ``phase`` is high to turn forward, and low to turn backward."""

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        return {"forward_is_high": not self.forward_is_high} if mistake == REVERSED else None

    def duties(self, duty: float) -> Mapping[int, float]:
        return {self.pwm: abs(duty)}

    def connections(self) -> Sequence[Connection]:
        return (*super().connections(), self.connect("pwm", self.pwm), gpio("phase", self.phase))

    def _open_output(self, name: str, context: DeviceContext) -> Output:
        with ExitStack() as opened:
            line = open_output(name, self.phase, context.pins, opened)
            chip = self.take_chip(name, context)
            return PhaseOutput(name, self, chip, line, opened.pop_all())


class PhaseOutput(ChannelOutput):
    """The channel and the GPIO of one motor.

    line: gpiozero's output for the direction.
    opened: the stack whose `close` frees the GPIO.
    """

    _driver: PhaseChannelDriver

    def __init__(self, motor: str, driver: PhaseChannelDriver, chip: PwmChip, line: Any, opened: ExitStack) -> None:
        super().__init__(motor, driver, chip)
        self._line, self._opened = line, opened

    def close(self) -> None:
        self._opened.close()

    def _set_direction(self, direction: int) -> None:
        if direction:
            with translate_pin_errors(self._motor, (self._driver.phase,)):
                self._line.value = (direction > 0) is self._driver.forward_is_high
