"""A motor on a board that takes a direction and a duty: DRV8835, DRV8838, MAX14870, TB67H420FTG."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from drivers.raspberrypi.gpio import Gpio, gpio
from drivers.raspberrypi.motors.bridge import Bridge
from drivers.raspberrypi.motors.driver import MotorDriver, MotorSettings
from drivers.raspberrypi.motors.outputs import digital_output, fall, pwm_output
from robotcore.hardware import Connection, Host

if TYPE_CHECKING:
    from gpiozero import DigitalOutputDevice, PWMOutputDevice


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
    parts = ("drv8835", "drv8838", "max14870", "tb67h420", "md10c")

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
            fall(self._enable)
            return
        if (is_backward := duty < 0) != self._is_backward:
            fall(self._enable)
            self._is_backward = is_backward
        self._phase.value = is_backward
        self._enable.value = abs(duty)
