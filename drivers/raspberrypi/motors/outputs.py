"""Lines that go out to a motor board, each opened on its own, so that an error names it."""

from __future__ import annotations

from contextlib import ExitStack
from typing import TYPE_CHECKING

from drivers.raspberrypi.claiming import claiming

if TYPE_CHECKING:
    from gpiozero import DigitalOutputDevice, Factory, PWMOutputDevice


def pwm_output(device: str, number: int, frequency_hz: int, pins: Factory, opened: ExitStack) -> PWMOutputDevice:
    """Return a line whose ``value`` is a duty from 0 to 1, low by now; raises DeviceError."""
    from gpiozero import PWMOutputDevice

    with claiming(device, (number,)):
        return opened.enter_context(PWMOutputDevice(number, frequency=frequency_hz, pin_factory=pins))


def digital_output(device: str, number: int, pins: Factory, opened: ExitStack, *, is_high: bool) -> DigitalOutputDevice:
    """Return a line that is high or low; raises DeviceError."""
    from gpiozero import DigitalOutputDevice

    with claiming(device, (number,)):
        return opened.enter_context(DigitalOutputDevice(number, initial_value=is_high, pin_factory=pins))


def fall(output: PWMOutputDevice) -> None:
    """Make a line low at once, its PWM ready for the next duty.

    lgpio lets a line of duty 0 fall in the course of its cycle: in a process that is suspended before, it stays high.
    """
    frequency = output.frequency
    if output.value:
        output.frequency = None
    output.off()
    output.frequency = frequency
