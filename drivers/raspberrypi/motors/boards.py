"""The drivers of two kinds of motor boards: H-bridges with two inputs, and boards with a direction and a PWM input."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.motors.driver import (
    Bridge,
    MotorDriver,
    MotorSettings,
    open_digital_output,
    open_pwm_output,
    set_low,
)
from robotcore.description import MotorDescription
from robotcore.hardware import Connection, Host

if TYPE_CHECKING:
    from gpiozero import DigitalOutputDevice, PWMOutputDevice


INPUTS = (
    "The inputs of boards. TB6612: forward AIN1 and BIN1, backward AIN2 and BIN2, standby STBY, and PWMA and PWMB to "
    "3.3 V. DRV8833: the same four, standby nSLEEP. L298N: forward IN1 and IN3, backward IN2 and IN4."
)
"""The note that `robotcore wiring` prints for a motor on an H-bridge."""


class HBridgeSettings(MotorSettings):
    """The settings of a motor on an H-bridge. If its wheel turns the wrong way, swap ``forward`` and ``backward``."""

    forward: Gpio
    """The GPIO of the input that is high if the motor turns forward."""

    backward: Gpio
    """The GPIO of the input that is high if the motor turns backward."""

    enable: Gpio | None = None
    """The GPIO of the board's enable input, which is high while the motor is open."""


class HBridge(MotorDriver[HBridgeSettings]):
    """Opens motors on an H-bridge with two inputs.

    The input of the commanded direction has the PWM, and the other input is low.
    """

    name = "h-bridge"
    summary = "a motor on an H-bridge with two inputs: L298N, DRV8833, TB6612, L9110S"
    settings = HBridgeSettings
    aliases = ("l298", "tb6612", "drv8833", "l9110", "mx1508")

    def wires(self, settings: HBridgeSettings) -> Sequence[Connection]:
        inputs = gpio("forward", settings.forward), gpio("backward", settings.backward)
        if settings.enable is None:
            return inputs
        return (
            *inputs,
            gpio(
                "enable",
                settings.enable,
                remedy="use the key 'standby' in place of 'enable', because motors may share a standby line",
            ),
        )

    def notes(self, description: MotorDescription, settings: HBridgeSettings) -> Sequence[str]:
        return (*super().notes(description, settings), INPUTS)

    def open_bridge(self, name: str, settings: HBridgeSettings, host: Host) -> Bridge:
        with ExitStack() as opened:
            forward, backward = (
                open_pwm_output(name, number, settings.frequency_hz, host.pins, opened)
                for number in (settings.forward, settings.backward)
            )
            if settings.enable is not None:
                open_digital_output(name, settings.enable, host.pins, opened, is_high=True)
            return TwoInputs(name, forward, backward, (settings.forward, settings.backward), opened.pop_all())


class TwoInputs(Bridge):
    """The two PWM inputs of an H-bridge."""

    def __init__(
        self,
        motor: str,
        forward: PWMOutputDevice,
        backward: PWMOutputDevice,
        gpios: Sequence[int],
        opened: ExitStack,
    ) -> None:
        super().__init__(motor, gpios, opened)
        self._forward, self._backward = forward, backward

    def set_duty(self, duty: float) -> None:
        if duty > 0:  # set one input low before the other gets high
            set_low(self._backward)
            self._forward.value = duty
        elif duty < 0:
            set_low(self._forward)
            self._backward.value = -duty
        else:
            try:
                set_low(self._forward)
            finally:
                set_low(self._backward)


class PhaseEnableSettings(MotorSettings):
    """The settings of a motor on a board with a direction input.

    If its wheel turns the wrong way, swap the motor's two wires.
    """

    phase: Gpio
    """The GPIO of the input PH or DIR, which is low to turn forward and high to turn backward."""

    enable: Gpio
    """The GPIO of the input EN or PWM, which has the PWM."""


class PhaseEnable(MotorDriver[PhaseEnableSettings]):
    """Opens motors on a board with an input for the direction and an input for the PWM."""

    name = "phase-enable"
    summary = "a motor on a board with a direction input and a PWM input: DRV8835, DRV8838, MAX14870"
    settings = PhaseEnableSettings
    aliases = ("drv8835", "drv8838", "max14870", "tb67h420", "md10c")

    def wires(self, settings: PhaseEnableSettings) -> Sequence[Connection]:
        return gpio("enable", settings.enable), gpio("phase", settings.phase)

    def find_turning_lines(self, settings: PhaseEnableSettings) -> tuple[int, ...]:
        return (settings.enable,)

    def open_bridge(self, name: str, settings: PhaseEnableSettings, host: Host) -> Bridge:
        with ExitStack() as opened:
            phase = open_digital_output(name, settings.phase, host.pins, opened, is_high=False)
            enable = open_pwm_output(name, settings.enable, settings.frequency_hz, host.pins, opened)
            return PhaseAndEnable(name, phase, enable, (settings.phase, settings.enable), opened.pop_all())


class PhaseAndEnable(Bridge):
    """The direction input and the PWM input of a board.

    The duty is set to 0 only if the direction changes. gpiozero's PhaseEnableMotor sets it to 0 at every
    command, and then loses a PWM cycle that begins at that moment.
    """

    def __init__(
        self,
        motor: str,
        phase: DigitalOutputDevice,
        enable: PWMOutputDevice,
        gpios: Sequence[int],
        opened: ExitStack,
    ) -> None:
        super().__init__(motor, gpios, opened)
        self._phase, self._enable = phase, enable
        self._is_backward = False

    def set_duty(self, duty: float) -> None:
        if duty == 0:
            set_low(self._enable)
            return
        if (is_backward := duty < 0) != self._is_backward:
            set_low(self._enable)
            self._is_backward = is_backward
        self._phase.value = is_backward
        self._enable.value = abs(duty)
