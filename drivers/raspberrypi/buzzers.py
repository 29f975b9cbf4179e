"""The driver of a buzzer on a GPIO."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any

from drivers.raspberrypi.header import Gpio, gpio
from drivers.raspberrypi.pins import PWM_HZ, open_output
from robotcore.description import RobotDescription
from robotcore.hardware import Connection, DeviceContext, DeviceDriver, Drivers
from robotcore.kinds.buzzer import SILENCE, Buzzer, BuzzerDescription

PASSIVE = (
    "Use a passive buzzer, which plays the tone of its pin. An active one has one tone of its own. Connect the buzzer "
    "through a transistor if it takes more than 16 mA."
)
"""The note that `robotcore wiring` prints for each buzzer."""


MAX_FREQUENCY_HZ = 10_000
"""The greatest frequency of lgpio's PWM, in Hz. Source: https://abyz.me.uk/lg/py_lgpio.html#tx_pwm."""


class PinBuzzer(Buzzer):
    """A passive buzzer on a GPIO. ``line`` is gpiozero's output with PWM."""

    def __init__(self, description: BuzzerDescription, line: Any, opened: ExitStack) -> None:
        super().__init__(description.name, **description.arguments())
        self._line, self._opened = line, opened

    def _apply(self, command: float) -> None:
        if command == SILENCE:
            self._line.value = 0.0
        else:
            self._line.frequency = round(command)  # lgpio takes whole Hz
            self._line.value = 0.5

    def _release(self) -> None:
        self._opened.close()


class PinBuzzerDriver(DeviceDriver):
    """Opens passive buzzers on a GPIO."""

    name = "buzzer"
    summary = "a passive buzzer on a GPIO"
    described = BuzzerDescription
    modules = ("gpiozero",)
    connector = "GPIO"
    remedy = "pip install 'robotcore[pi]'"
    supply = ("ground",)
    aliases = ("speaker", "piezo")

    gpio: Gpio

    def connections(self) -> Sequence[Connection]:
        return (gpio("gpio", self.gpio),)

    def check(self, description: BuzzerDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if description.max_frequency_hz > MAX_FREQUENCY_HZ:
            raise ValueError(
                f"max_frequency_hz is {description.max_frequency_hz:g}, and a pin of the Pi reaches "
                f"{MAX_FREQUENCY_HZ} Hz; reduce it"
            )

    def notes(self, description: BuzzerDescription) -> Sequence[str]:
        return (PASSIVE,)

    def open(self, description: BuzzerDescription, context: DeviceContext) -> Buzzer:
        with ExitStack() as opened:
            line = open_output(description.name, self.gpio, context.pins, opened, frequency_hz=PWM_HZ)
            return PinBuzzer(description, line, opened.pop_all())
