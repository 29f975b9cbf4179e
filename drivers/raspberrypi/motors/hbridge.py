"""A motor on an H-bridge with two inputs: L298N, L9110S, DRV8833, TB6612 with PWMA high."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from drivers.raspberrypi.gpio import Gpio, gpio
from drivers.raspberrypi.motors.bridge import Bridge
from drivers.raspberrypi.motors.driver import MotorDriver, MotorSettings
from drivers.raspberrypi.motors.outputs import digital_output, fall, pwm_output
from robotcore.description import MotorDescription
from robotcore.hardware import Connection, Host

if TYPE_CHECKING:
    from gpiozero import PWMOutputDevice


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
    parts = ("l298", "tb6612", "drv8833", "l9110", "mx1508")

    def wires(self, settings: HBridgeSettings) -> Sequence[Connection]:
        inputs = gpio("forward", settings.forward), gpio("backward", settings.backward)
        if settings.enable is None:
            return inputs
        return (*inputs, gpio("enable", settings.enable, instead="make it standby, which motors may share"))

    def notes(self, told: MotorDescription, settings: HBridgeSettings) -> Sequence[str]:
        return (*super().notes(told, settings), INPUTS)

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
            fall(self._backward)
            self._forward.value = duty
        elif duty < 0:
            fall(self._forward)
            self._backward.value = -duty
        else:
            try:
                fall(self._forward)
            finally:
                fall(self._backward)
