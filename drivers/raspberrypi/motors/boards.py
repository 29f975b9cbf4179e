"""The drivers of motor boards: an H-bridge with two inputs, and a board with a direction and a PWM input."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.motors.driver import Bridge, MotorDriver, MotorSettings, digital_output, pwm_output, set_low
from robotcore.description import MotorDescription
from robotcore.hardware import Connection, Host

if TYPE_CHECKING:
    from gpiozero import DigitalOutputDevice, PWMOutputDevice


INPUTS = (
    "Which of a board's inputs is which: TB6612: forward AIN1 and BIN1, backward AIN2 and BIN2, standby STBY, and PWMA "
    "and PWMB to 3.3 V. DRV8833: the same four, standby nSLEEP. L298N: forward IN1 and IN3, backward IN2 and IN4."
)
"""What whoever connects one must know besides."""


class HBridgeSettings(MotorSettings):
    """``forward`` high turns one way, ``backward`` high the other; ``enable`` is high while the motor is open.

    Where a wheel turns the wrong way, swap the two.
    """

    forward: Gpio
    backward: Gpio
    enable: Gpio | None = None


class HBridge(MotorDriver[HBridgeSettings]):
    """PWM on the input of the direction, the other one low."""

    name = "h-bridge"
    summary = "a motor on an H-bridge with two inputs: L298N, DRV8833, TB6612, L9110S"
    settings = HBridgeSettings
    aliases = ("l298", "tb6612", "drv8833", "l9110", "mx1508")

    def wires(self, settings: HBridgeSettings) -> Sequence[Connection]:
        inputs = gpio("forward", settings.forward), gpio("backward", settings.backward)
        if settings.enable is None:
            return inputs
        return (*inputs, gpio("enable", settings.enable, instead="make it standby, which motors may share"))

    def notes(self, description: MotorDescription, settings: HBridgeSettings) -> Sequence[str]:
        return (*super().notes(description, settings), INPUTS)

    def bridge(self, name: str, settings: HBridgeSettings, host: Host) -> Bridge:
        with ExitStack() as opened:
            forward, backward = (
                pwm_output(name, number, settings.frequency_hz, host.pins, opened)
                for number in (settings.forward, settings.backward)
            )
            if settings.enable is not None:
                digital_output(name, settings.enable, host.pins, opened, is_high=True)
            return TwoInputs(name, forward, backward, (settings.forward, settings.backward), opened.pop_all())


class TwoInputs(Bridge):
    """The two inputs of an H-bridge."""

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

    def put(self, duty: float) -> None:
        if duty > 0:  # what goes low goes first
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
    """``phase`` (PH, DIR) is low to turn forward and high to turn backward; ``enable`` (EN, PWM) gets the duty.

    Where a wheel turns the wrong way, swap the motor's own two wires.
    """

    phase: Gpio
    enable: Gpio


class PhaseEnable(MotorDriver[PhaseEnableSettings]):
    """PWM on one line, the direction on another."""

    name = "phase-enable"
    summary = "a motor on a board with a direction input and a PWM input: DRV8835, DRV8838, MAX14870"
    settings = PhaseEnableSettings
    aliases = ("drv8835", "drv8838", "max14870", "tb67h420", "md10c")

    def wires(self, settings: PhaseEnableSettings) -> Sequence[Connection]:
        return gpio("enable", settings.enable), gpio("phase", settings.phase)

    def turning(self, settings: PhaseEnableSettings) -> tuple[int, ...]:
        return (settings.enable,)

    def bridge(self, name: str, settings: PhaseEnableSettings, host: Host) -> Bridge:
        with ExitStack() as opened:
            phase = digital_output(name, settings.phase, host.pins, opened, is_high=False)
            enable = pwm_output(name, settings.enable, settings.frequency_hz, host.pins, opened)
            return PhaseAndEnable(name, phase, enable, (settings.phase, settings.enable), opened.pop_all())


class PhaseAndEnable(Bridge):
    """A direction and a duty.

    gpiozero's PhaseEnableMotor takes the duty away at every command, which a PWM cycle that begins meanwhile misses;
    here it goes only where the direction turns.
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

    def put(self, duty: float) -> None:
        if duty == 0:
            set_low(self._enable)
            return
        if (is_backward := duty < 0) != self._is_backward:
            set_low(self._enable)
            self._is_backward = is_backward
        self._phase.value = is_backward
        self._enable.value = abs(duty)
