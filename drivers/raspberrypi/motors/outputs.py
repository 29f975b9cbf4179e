"""Lines that go out to a motor board, each opened on its own, so that an error names it."""

from __future__ import annotations

from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING

from drivers.raspberrypi.claiming import claiming

if TYPE_CHECKING:
    from gpiozero import DigitalOutputDevice, Factory, PWMOutputDevice


def pwm_output(device: str, number: int, frequency_hz: int, pins: Factory, opened: ExitStack) -> PWMOutputDevice:
    """Return a line whose ``value`` is a duty from 0 to 1, low by now; raises DeviceError."""
    from gpiozero import PWMOutputDevice

    with claiming(device, (number,)):
        output = PWMOutputDevice(number, frequency=frequency_hz, pin_factory=pins)
        opened.callback(_pull_down, device, number, pins)
        return opened.enter_context(output)


def digital_output(device: str, number: int, pins: Factory, opened: ExitStack, *, is_high: bool) -> DigitalOutputDevice:
    """Return a line that is high or low; raises DeviceError."""
    from gpiozero import DigitalOutputDevice

    with claiming(device, (number,)):
        output = DigitalOutputDevice(number, initial_value=is_high, pin_factory=pins)
        opened.callback(_pull_down, device, number, pins)
        return opened.enter_context(output)


def _pull_down(device: str, number: int, pins: Factory) -> None:
    """Pull a line down that is closed: gpiozero leaves it floating until the Pi is started again.

    A board without resistors of its own, such as one with an L298N, takes a floating input for high or for noise.
    """
    from gpiozero import PinFixedPull

    with claiming(device, (number,)), suppress(PinFixedPull):  # GPIO 2 and 3 have resistors to 3.3 V on the Pi
        pins.pin(number).pull = "down"


def fall(output: PWMOutputDevice) -> None:
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
