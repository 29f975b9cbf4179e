"""The output lines to a motor board, and the bridge that turns one motor by them."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING

from drivers.raspberrypi.pins import build_pin_error, translate_pin_errors
from robotcore.hardware.motor_model import Output

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
