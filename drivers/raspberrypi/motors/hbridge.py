"""A motor on an H-bridge with two inputs: L298N, L9110S, DRV8833, TB6612 with PWMA high."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from drivers.raspberrypi.gpio import Gpio, gpio
from drivers.raspberrypi.motors.driver import MotorDriver, MotorSettings
from drivers.raspberrypi.motors.motor import Bridge
from drivers.raspberrypi.motors.outputs import digital_output, fall, pwm_output
from robotcore.hardware import Connection, Host

if TYPE_CHECKING:
    from gpiozero import PWMOutputDevice


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
        return inputs if settings.enable is None else (*inputs, gpio("enable", settings.enable))

    def bridge(self, name: str, settings: HBridgeSettings, host: Host) -> Bridge:
        with ExitStack() as opened:
            forward, backward = (
                pwm_output(name, number, settings.frequency_hz, host.pins, opened)
                for number in (settings.forward, settings.backward)
            )
            if settings.enable is not None:
                digital_output(name, settings.enable, host.pins, opened, is_high=True)
            return TwoInputs(forward, backward, (settings.forward, settings.backward), opened.pop_all())


class TwoInputs(Bridge):
    """The two inputs of an H-bridge."""

    def __init__(
        self, forward: PWMOutputDevice, backward: PWMOutputDevice, gpios: Sequence[int], opened: ExitStack
    ) -> None:
        super().__init__(gpios, opened)
        self._forward, self._backward = forward, backward

    def turn(self, duty: float) -> None:
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
