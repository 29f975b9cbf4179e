"""The GPIOs of one motor as an output for duties, with lgpio's software PWM."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, Any

from drivers.raspberrypi.pins import build_pin_error, translate_pin_errors
from robotcore.hardware.motor_model import Output

if TYPE_CHECKING:
    from gpiozero import DigitalOutputDevice, Factory, PWMOutputDevice

Levels = Callable[[float], Mapping[int, float]]
"""A function that returns the level of each GPIO at a duty from -1 to 1, in the order in which the levels are set."""


def open_output(
    device: str,
    number: int,
    pins: Factory,
    opened: ExitStack,
    *,
    frequency_hz: int | None = None,
    is_high: bool = False,
) -> PWMOutputDevice | DigitalOutputDevice:
    """Open a GPIO as an output, and return it; raises DeviceError. A GPIO with PWM is low at first.

    device: the motor's name, for errors.
    opened: the stack whose `close` frees the GPIO and pulls it down.
    frequency_hz: the frequency of the PWM; None means no PWM.
    is_high: the first level of a GPIO without PWM.
    """
    from gpiozero import DigitalOutputDevice, PWMOutputDevice

    with translate_pin_errors(device, (number,)):
        if frequency_hz is None:
            output = DigitalOutputDevice(number, initial_value=is_high, pin_factory=pins)
        else:
            output = PWMOutputDevice(number, frequency=frequency_hz, pin_factory=pins)
        opened.callback(_pull_down, device, number, pins)
        return opened.enter_context(output)


def _pull_down(device: str, number: int, pins: Factory) -> None:
    # gpiozero leaves a closed GPIO floating until the Pi starts again. A board without resistors, such as an L298N's,
    # reads a floating input as high or as noise.
    from gpiozero import PinFixedPull

    with (
        translate_pin_errors(device, (number,)),
        suppress(PinFixedPull),
    ):  # GPIO 2 and 3 have resistors to 3.3 V on the Pi
        pins.pin(number).pull = "down"


class Bridge(Output):
    """The outputs to the inputs of a motor board, for one motor.

    Before the motor changes its direction, and at a stop, every output is set low.

    motor: the motor's name, for errors.
    outputs: gpiozero's outputs by their GPIOs, those with PWM last.
    levels: returns the levels of the outputs at a duty.
    opened: the stack whose `close` frees the GPIOs.
    """

    def __init__(self, motor: str, outputs: Mapping[int, Any], levels: Levels, opened: ExitStack) -> None:
        self._motor, self._outputs, self._levels, self._opened = motor, outputs, levels, opened
        self._direction = 0

    def turn(self, duty: float) -> None:
        try:
            self._set_duty(round_to_percent(duty))
        except Exception as error:
            raise build_pin_error(self._motor, tuple(self._outputs), error) from error

    def close(self) -> None:
        """Close every line, even if an error occurs at another line."""
        with translate_pin_errors(self._motor, tuple(self._outputs)):
            self._opened.close()

    def _set_duty(self, duty: float) -> None:
        direction = (duty > 0) - (duty < 0)
        if direction != self._direction or not direction:
            self._direction = 0
            self._set_low()
            self._direction = direction
        if direction:
            for number, level in self._levels(duty).items():
                self._outputs[number].value = level

    def _set_low(self) -> None:
        with ExitStack() as stopping:  # calls every callback, even if one raises; the last one first
            for output in self._outputs.values():
                stopping.callback(set_low, output)


def set_low(output: PWMOutputDevice | DigitalOutputDevice) -> None:
    """Set an output low at once. Its PWM works again with the next duty.

    The duty 0 alone is not sufficient, because lgpio sets the line low only at the next step of the PWM cycle. If the
    process is suspended before that step, the line stays high.
    """
    frequency = getattr(output, "frequency", None)
    if frequency is None or not output.value:
        output.off()
        return
    output.frequency = None
    try:
        output.off()
    finally:
        output.frequency = frequency  # without a frequency, any duty above 0 is full duty


def round_to_percent(duty: float) -> float:
    """Return a duty rounded to whole percent, the resolution of lgpio.

    lgpio computes ``int(duty * 100)``. So the result is slightly larger where a float would be rounded down.

    >>> int(0.29 * 100), int(round_to_percent(0.29) * 100)
    (28, 29)
    """
    percent = round(abs(duty) * 100)
    rounded = percent / 100
    if int(rounded * 100) < percent:
        rounded = math.nextafter(rounded, 1)
    return math.copysign(rounded, duty)
