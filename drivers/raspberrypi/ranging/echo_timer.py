"""Time the echo pulses of an ultrasonic module: a distance, nothing in range, or no result."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from enum import Enum, auto
from typing import Any

from robotcore.errors import DeviceError
from robotcore.hardware.polled import RangeSampler

LONGEST_ECHO_S = 0.027
"""The module hears as far as 4 m, which takes 26 ms at −40 °C; what takes longer may be no echo.
Source: HC-SR04 data sheet, ElecFreaks: ranging distance 2 cm to 4 m."""

SILENCE_S = 0.030
"""A pulse of at least this length is the module's own time-out: 38 ms by the data sheet, up to 200 ms on copies."""

STUCK_S = 0.3
"""No module holds its echo high for longer."""

UNANSWERED_CYCLES = 5
"""So many triggers in a row without an answer are a fault."""


class _Echo(Enum):
    OVER = auto()
    AWAITED = auto()
    HIGH = auto()


class EchoTimer:
    """Judges an ultrasonic module's cycles by the edges of its echo.

    A sample comes of one pulse, both edges of it after the same trigger; its time is when the trigger was given, on
    the clock of ``begin``. Edges may come from any thread, with the ticks of the pin factory; ``elapsed(later,
    earlier)`` is the time between two of these in seconds, and ``speed`` that of sound in m/s.
    """

    def __init__(
        self, device: str, findings: RangeSampler, speed: float, cycle_s: float, elapsed: Callable[[Any, Any], float]
    ) -> None:
        self.ended = threading.Event()
        """Set when nothing more is to come in this cycle."""
        self._device, self._findings, self._speed = device, findings, speed
        self._cycle_s, self._elapsed = cycle_s, elapsed
        self._lock = threading.Lock()
        self._echo = _Echo.OVER
        self._time = 0.0
        self._triggered: Any = None
        self._risen: Any = None
        self._unanswered = self._waited = 0

    def begin(self, time: float, ticks: Any) -> None:
        """Close the cycle before, and listen for the echo of the trigger that is given now."""
        with self._lock:
            self._waited = 0
            self._unanswered = self._unanswered + 1 if self._echo is _Echo.AWAITED else 0
            if self._echo is not _Echo.OVER:  # it did not rise, or an edge was lost
                self._findings.add_unclear()
            if self._unanswered >= UNANSWERED_CYCLES:
                self._findings.fail(DeviceError(self._device, _UNANSWERED, kind="trigger-unanswered"))
            self._time, self._triggered, self._echo = time, ticks, _Echo.AWAITED
            self.ended.clear()

    def wait(self) -> None:
        """Let a cycle pass without a trigger: the echo of the last one is still high."""
        with self._lock:
            self._waited += 1
            self.ended.clear()
            if self._waited * self._cycle_s > STUCK_S:
                self._echo = _Echo.OVER
                self._findings.fail(DeviceError(self._device, _STUCK, kind="echo-stuck"))

    def edge(self, ticks: Any, is_high: bool) -> None:  # noqa: FBT001  gpiozero's pins call it so
        """Take an edge of the echo; one from before the trigger, or after the pulse, says nothing."""
        with self._lock:
            if self._echo is _Echo.OVER or self._elapsed(ticks, self._triggered) < 0:
                return
            self._findings.clear_failure()
            if is_high and self._echo is _Echo.AWAITED:
                self._risen, self._echo = ticks, _Echo.HIGH
                return
            is_whole = self._echo is _Echo.HIGH and not is_high
            self._echo = _Echo.OVER
            self._classify(self._elapsed(ticks, self._risen) if is_whole else math.nan)
            self.ended.set()

    def fail(self, error: Exception) -> None:
        """Let the sensor fail, until it is heard again."""
        with self._lock:
            self._findings.fail(error)

    def stop(self) -> None:
        """Take no edge any more."""
        with self._lock:
            self._echo = _Echo.OVER

    def _classify(self, pulse: float) -> None:
        """Tell what a pulse of that many seconds says; it is NaN where an edge of it is missing."""
        if 0 <= pulse <= LONGEST_ECHO_S:
            self._findings.add_distance(pulse * self._speed / 2, self._time)
        elif SILENCE_S <= pulse <= STUCK_S:
            self._findings.add_no_echo(self._time)
        else:
            self._findings.add_unclear()


_UNANSWERED = "does not answer its trigger; look at its 5 V and its ground, and whether trigger and echo are swapped"
_STUCK = "its echo stays high; look at the wire and the divider at echo, and switch its 5 V off and on again"
