"""An ultrasonic sensor on two pins: a trigger, and a pulse as long as the echo takes."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from drivers.raspberrypi.virtual.pins import VirtualPin
from robotcore.hal.clock import Clock
from robotcore.hal.devices import RangeSensor

BURST_S = 450e-6
"""From the end of the trigger to the rise of the echo: the burst is sent, eight cycles at 40 kHz, and some more."""
SILENCE_S = 38e-3
"""The pulse of an HC-SR04 that heard nothing. Source: its data sheet."""


class VirtualEcho:
    """Answers each trigger by what the simulator's ``sensor`` hears at that instant.

    An echo that ``is_lost``, as one that glances off, is silence to the module. Edges come in the step after they are
    due, and tell when they were.
    """

    def __init__(
        self,
        clock: Clock,
        sensor: RangeSensor,
        trigger: VirtualPin,
        echo: VirtualPin,
        speed_of_sound: float,
        is_lost: Callable[[], bool],
    ) -> None:
        self._clock, self._sensor = clock, sensor
        self._trigger, self._echo = trigger, echo
        self._speed, self._is_lost = speed_of_sound, is_lost
        self._is_busy = False
        echo.drive(0)
        trigger.on_change(self._triggered)

    def _triggered(self) -> None:
        if not (self._trigger.state or self._is_busy):
            self._is_busy = True
            self._send()

    def _send(self) -> None:
        rises = self._clock.now() + BURST_S
        distance = math.inf if self._is_lost() else self._sensor.read().distance
        falls = rises + (SILENCE_S if math.isinf(distance) else 2 * distance / self._speed)
        self._call_at(rises, partial(self._echo.drive, 1, rises))
        self._call_at(falls, partial(self._end, falls))

    def _end(self, at: float) -> None:
        self._is_busy = False
        self._echo.drive(0, at)

    def _call_at(self, at: float, edge: Callable[[], None]) -> None:
        if self._clock.now() == 0:  # the robot is being opened: no time can pass, and drivers want a first sample
            edge()
        else:
            self._clock.call_at(at, edge)
