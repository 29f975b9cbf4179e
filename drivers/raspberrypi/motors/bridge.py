"""The GPIOs of one motor as an output for duties, with lgpio's software PWM."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from drivers.raspberrypi.pins import build_pin_error, translate_pin_errors
from robotcore.hardware.motor_model import Output

if TYPE_CHECKING:
    from gpiozero import DigitalOutputDevice, PWMOutputDevice

Levels = Callable[[float], Mapping[int, float]]
"""A function that returns the level of each GPIO at a duty from -1 to 1, in the order in which the levels are set."""


class Bridge(Output):
    """The outputs to the inputs of a motor board, for one motor.

    Before the motor changes its direction, and at a stop, every output is set low.

    A duty is sent in whole percent. The rounding error of a duty is added to the next duty, so that the mean of
    many duties is exact.

    motor: the motor's name, for errors.
    outputs: gpiozero's outputs by their GPIOs, those with PWM last.
    levels: returns the levels of the outputs at a duty.
    opened: the stack whose `close` frees the GPIOs.
    """

    def __init__(self, motor: str, outputs: Mapping[int, Any], levels: Levels, opened: ExitStack) -> None:
        self._motor, self._outputs, self._levels, self._opened = motor, outputs, levels, opened
        self._direction = 0
        self._left_over = 0.0

    def turn(self, duty: float) -> None:
        try:
            self._set_duty(self._round(duty))
        except Exception as error:
            raise build_pin_error(self._motor, tuple(self._outputs), error) from error

    def close(self) -> None:
        """Close every line, even if an error occurs at another line."""
        with translate_pin_errors(self._motor, tuple(self._outputs)):
            self._opened.close()

    def _round(self, duty: float) -> float:
        if not duty or duty * self._direction <= 0:
            self._left_over = 0.0
        wanted = duty + self._left_over
        sent = round_to_percent(max(-1.0, min(wanted, 1.0)))
        self._left_over = wanted - sent if duty else 0.0
        return sent if sent * duty > 0 else 0.0

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
