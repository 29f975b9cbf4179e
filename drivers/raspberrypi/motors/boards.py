"""The drivers of two kinds of motor boards: H-bridges with two inputs, and boards with a direction and a PWM input."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from typing import Annotated, Any, ClassVar

from pydantic import Field

from drivers.raspberrypi.header import HELD_UP, PULLED_UP, Gpio, gpio
from drivers.raspberrypi.motors.bridge import Bridge
from drivers.raspberrypi.pins import open_output
from robotcore.description import RobotDescription
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.device_test import REVERSED
from robotcore.hardware import Connection, DeviceContext, DeviceDriver, Drivers
from robotcore.hardware.motor_control import Control, open_motor, require_drivable
from robotcore.hardware.motor_model import Model
from robotcore.kinds.motor import Motor, MotorDescription

BATTERY = (
    "The motors need a battery of their own. A pad of the header gives too little current, and the motors disturb it. "
    "Join the grounds of the battery, the motor board and the Pi."
)
PULLED_DOWN = (
    "A resistor of 10 kΩ from GPIO {line} (standby) to ground keeps the motors off while the Pi starts, and if no "
    "program drives that line. Remove a pull-up of that line on the motor board."
)
UNGUARDED = (
    "Connect 10 kΩ from each of these lines to ground: GPIO {lines}. The resistors keep the motor off while the Pi "
    "starts, and if no program drives the lines."
)
"""The note that `robotcore wiring` prints for a motor without a standby line."""
NO_STANDBY = (
    "There is no standby line. If the kernel keeps the levels of outputs (see robotcore doctor), motors may continue "
    "to turn after the program and its guardian were killed. A standby line prevents that: connect STBY, nSLEEP, or "
    "an L298N's joined ENA and ENB (jumpers off) to one GPIO. Set standby of both motors to it, and remove an L298N's "
    "enable and pwm."
)
RISING = (
    "GPIO 0 to 8 are pulled up from power-on until a program uses them, and {lines} may turn this motor during that "
    "time. Use GPIO 9 to 27, resistors of 10 kΩ to ground, or a standby line."
)
"""The warning that `robotcore wiring` prints for a motor on GPIO 0 to 8."""
CONSOLE_GPIO = 14
CONSOLE = (
    f"GPIO {CONSOLE_GPIO} is high while the Pi starts if the serial console is on, and may turn this motor. Switch the "
    "console off (sudo raspi-config, Interface Options, Serial Port), or use another GPIO."
)
"""The warning that `robotcore wiring` prints for a motor on the GPIO by which the serial console sends."""

MAX_SILENCE_S = 0.25
"""The time for which the guardian does not kill a silent app, in seconds. The app may be swapping, collecting garbage,
or waiting for a slow SD card."""


class MotorDriver(DeviceDriver):
    """The base class of the drivers of motors on GPIOs. A subclass defines the signals and their levels.

    A new duty takes effect with the next cycle of lgpio's software PWM, up to ``1 / frequency_hz`` seconds later. A
    stop takes effect at once.
    """

    described = MotorDescription
    modules = ("gpiozero",)
    connector = "GPIO"
    supply = ("ground",)
    remedy = "pip install 'robotcore[pi]'"
    reports_direction = True

    signals: ClassVar[tuple[str, ...]]
    """The keys of the settings with the motor's own GPIOs. A GPIO without a level is high while the motor is open."""

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

    @abstractmethod
    def levels(self, duty: float) -> Mapping[int, float]:
        """Return the level of each GPIO at a duty from -1 to 1, in the order in which the levels are set.

        A GPIO whose level is a bool has no PWM. If all others are low, the motor stands.
        """

    def wires(self) -> Sequence[Connection]:
        """Return the connections to the motor's own GPIOs, without standby."""
        lines = ((signal, getattr(self, signal)) for signal in self.signals)
        return [gpio(signal, line) for signal, line in lines if line is not None]

    def connections(self) -> Sequence[Connection]:
        wires = self.wires()
        return wires if self.standby is None else (*wires, gpio("standby", self.standby, is_shared=True))

    def notes(self, description: MotorDescription) -> Sequence[str]:
        if self.standby is not None:
            return BATTERY, PULLED_DOWN.format(line=self.standby)
        enable = [int(wire.where) for wire in self.wires() if wire.signal == "enable"]
        lines = enable or self._find_turning_lines()
        return BATTERY, UNGUARDED.format(lines=", ".join(map(str, lines))), NO_STANDBY

    def warnings(self) -> Sequence[str]:
        turning = self._find_turning_lines()
        lines = [line for line in turning if line in PULLED_UP]
        rising = (RISING.format(lines=f"GPIO {', '.join(map(str, lines))}"),) if lines else ()
        return (*rising, *([CONSOLE] if CONSOLE_GPIO in turning else []))

    def check(self, description: MotorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if held := [line for line in self._find_turning_lines() if line in HELD_UP]:
            raise ValueError(
                f"GPIO {held[0]} is held high by a resistor on the Pi, so {description.name} may turn while no program "
                "runs; use another GPIO, best of 9 to 27"
            )
        require_drivable(description, self.model, self.control, robot)
        if self.control and self.control.period_s * self.frequency_hz < 1:
            raise ValueError(
                f"control.period_s {self.control.period_s:g} is shorter than a cycle of {self.frequency_hz} "
                "Hz; lengthen it, or raise frequency_hz"
            )

    def open(self, description: MotorDescription, context: DeviceContext) -> Motor:
        bridge = partial(self._open_bridge, description.name, context)
        return open_motor(description, self.model, self.control, bridge, context)

    def cutoffs(self, description: MotorDescription, context: DeviceContext) -> Sequence[CutoffSpec]:
        from gpiozero.pins.mock import MockFactory

        if isinstance(context.pins, MockFactory):  # no other process sees these pins
            return ()
        if self.standby is not None:
            return (CutoffSpec(description.name, "drivers.raspberrypi.cutoff:StandbyLine", {"line": self.standby}),)
        lines = {"lines": self._find_lines(), "owner": context.owner}
        return (CutoffSpec(description.name, "drivers.raspberrypi.cutoff:MotorLines", lines, MAX_SILENCE_S),)

    def _open_bridge(self, name: str, context: DeviceContext) -> Bridge:
        with ExitStack() as opened:
            outputs = {}
            for line, level in self.levels(0.0).items():
                frequency_hz = None if isinstance(level, bool) else self.frequency_hz
                outputs[line] = open_output(name, line, context.pins, opened, frequency_hz=frequency_hz)
            for line in self._find_lines():
                if line not in outputs:
                    open_output(name, line, context.pins, opened, is_high=True)
            return Bridge(name, outputs, self.levels, opened.pop_all())

    def _find_lines(self) -> list[int]:
        return [int(wire.where) for wire in self.wires()]

    def _find_turning_lines(self) -> list[int]:
        """Return the GPIOs that may turn the motor if they are high."""
        if self.standby is not None:
            return [self.standby]
        levels = self.levels(0.0)
        return [line for line in self._find_lines() if not isinstance(levels.get(line), bool)]


INPUTS = (
    "The inputs of boards. TB6612: forward AIN1 and BIN1, backward AIN2 and BIN2, standby STBY, pwm PWMA and PWMB, or "
    "these two to 3.3 V. DRV8833: forward AIN1 and BIN1, backward AIN2 and BIN2, standby nSLEEP. L298N: forward IN1 "
    "and IN3, backward IN2 and IN4, pwm or enable ENA and ENB, or the jumpers on these two."
)
"""The note that `robotcore wiring` prints for a motor on an H-bridge."""
H_BRIDGE_SUPPLIES = (
    "The supply of boards. TB6612: VCC to 3.3 V, VM to plus of the battery; without VCC no motor turns. DRV8833: VM "
    "to plus of the battery, no other supply. L298N: 12V to plus of the battery; with the jumper of the regulator on, "
    "the board makes its own 5 V, and its 5V stays free."
)
PHASE_ENABLE_SUPPLIES = (
    "The supply of boards. DRV8835 and DRV8838: VCC to 3.3 V, VIN to plus of the battery; without VCC no motor turns. "
    "MD10C: the battery, no other supply."
)


class HBridge(MotorDriver):
    """Opens motors on an H-bridge with two inputs. If a wheel turns the wrong way, swap ``forward`` and ``backward``.

    The input of the commanded direction is high, and the other input is low. The input ``pwm`` has the PWM. A board
    without it has the PWM at the input of the commanded direction.
    """

    name = "h-bridge"
    summary = "a motor on an H-bridge with two inputs: L298N, DRV8833, TB6612, L9110S"
    aliases = ("l298", "tb6612", "drv8833", "l9110", "mx1508")
    signals = ("forward", "backward", "pwm", "enable")

    forward: Gpio
    """The GPIO of the input that is high if the motor turns forward."""

    backward: Gpio
    """The GPIO of the input that is high if the motor turns backward."""

    pwm: Gpio | None = None
    """The GPIO of the motor's PWM input (TB6612: PWMA or PWMB, L298N: ENA or ENB), which then has the PWM.

    Without it, the inputs ``forward`` and ``backward`` have the PWM.
    """

    enable: Gpio | None = None
    """The GPIO of the board's enable input, which is high while the motor is open."""

    def wires(self) -> Sequence[Connection]:
        remedy = "use the key 'standby' in place of 'enable', because motors may share a standby line"
        return [replace(wire, remedy=remedy if wire.signal == "enable" else "") for wire in super().wires()]

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        return {"forward": self.backward, "backward": self.forward} if mistake == REVERSED else None

    def levels(self, duty: float) -> Mapping[int, float]:
        if self.pwm is None:
            return {self.forward: max(duty, 0), self.backward: max(-duty, 0)}
        return {self.forward: duty > 0, self.backward: duty < 0, self.pwm: abs(duty)}

    def notes(self, description: MotorDescription) -> Sequence[str]:
        return (*super().notes(description), INPUTS, H_BRIDGE_SUPPLIES)


class PhaseEnable(MotorDriver):
    """Opens motors on a board with an input for the direction and an input for the PWM.

    If a wheel turns the wrong way, swap the motor's two wires.
    """

    name = "phase-enable"
    summary = "a motor on a board with a direction input and a PWM input: DRV8835, DRV8838, MAX14870"
    aliases = ("drv8835", "drv8838", "max14870", "tb67h420", "md10c")
    signals = ("enable", "phase")

    phase: Gpio
    """The GPIO of the input PH or DIR, which is low to turn forward and high to turn backward."""

    enable: Gpio
    """The GPIO of the input EN or PWM, which has the PWM."""

    def notes(self, description: MotorDescription) -> Sequence[str]:
        return (*super().notes(description), PHASE_ENABLE_SUPPLIES)

    def levels(self, duty: float) -> Mapping[int, float]:
        return {self.phase: duty < 0, self.enable: abs(duty)}
