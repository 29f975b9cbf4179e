"""What the echo pulses of an ultrasonic module say: a distance, that nothing is in range, or nothing at all."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

from robotcore.devices import Range
from robotcore.errors import DeviceError
from robotcore.hardware import Newest

LONGEST_ECHO_S = 0.027
"""The module hears as far as 4 m, which takes 26 ms at −40 °C; what takes longer may be no echo.
Source: HC-SR04 data sheet, ElecFreaks: ranging distance 2 cm to 4 m."""

SILENCE_S = 0.030
"""A pulse of at least this length is the module's own time-out: 38 ms by the data sheet, up to 200 ms on copies."""

STUCK_S = 0.3
"""No module holds its echo high for longer."""

UNANSWERED_CYCLES = 5
"""So many triggers in a row without an answer are a fault."""

_LATE_S = 10.0
"""An edge so long after its trigger came before it, by a counter of ticks that began again."""


@dataclass(frozen=True)
class Acoustics:
    """What pulses mean: the speed of sound in m/s, the nearest and the farthest distance that is told, in metres.

    So many ``echo_free_cycles`` in a row vouch for nothing in range; where it is 0, none do.
    """

    speed: float
    min_range: float
    max_range: float
    echo_free_cycles: int


class _Echo(Enum):
    OVER = auto()
    AWAITED = auto()
    HIGH = auto()


class Hearing:
    """Judges an ultrasonic module's cycles by the edges of its echo; ``newest`` has what came of them.

    A sample comes of one pulse, both edges of it after the same trigger; its time is when the trigger was given, on
    the clock of ``begin``. What cannot be judged gives no sample. Edges may come from any thread, with the ticks of the
    pin factory; ``elapsed(later, earlier)`` is the time between two of these, in seconds.
    """

    def __init__(self, device: str, acoustics: Acoustics, cycle_s: float, elapsed: Callable[[Any, Any], float]) -> None:
        self.newest: Newest[Range] = Newest(device, DeviceError(device, _NOTHING_YET))
        self.has_told = False
        """Whether there has been a sample, or a fault."""
        self.ended = threading.Event()
        """Set when nothing more is to come in this cycle."""
        self._device, self._acoustics, self._cycle_s, self._elapsed = device, acoustics, cycle_s, elapsed
        self._lock = threading.Lock()
        self._echo = _Echo.OVER
        self._time = 0.0
        self._triggered: Any = None
        self._risen: Any = None
        self._last: Range | None = None
        self._is_failed = False
        self._unanswered = self._waited = self._silent = 0

    def begin(self, time: float, ticks: Any) -> None:
        """Close the cycle before, and listen for the echo of the trigger that is given now."""
        with self._lock:
            self._waited = 0
            self._unanswered = self._unanswered + 1 if self._echo is _Echo.AWAITED else 0
            if self._echo is not _Echo.OVER:  # it did not rise, or an edge was lost
                self._silent = 0
            if self._unanswered >= UNANSWERED_CYCLES:
                self._fail(DeviceError(self._device, _UNANSWERED))
            self._time, self._triggered, self._echo = time, ticks, _Echo.AWAITED
            self.ended.clear()

    def wait(self) -> None:
        """Let a cycle pass without a trigger: the echo of the last one is still high."""
        with self._lock:
            self._waited += 1
            self.ended.clear()
            if self._waited * self._cycle_s > STUCK_S:
                self._echo, self._silent = _Echo.OVER, 0
                self._fail(DeviceError(self._device, _STUCK))

    def edge(self, ticks: Any, is_high: bool) -> None:  # noqa: FBT001  gpiozero's pins call it so
        """Take an edge of the echo; one from before the trigger, or after the pulse, says nothing."""
        with self._lock:
            if self._echo is _Echo.OVER or not 0 <= self._elapsed(ticks, self._triggered) < _LATE_S:
                return
            self._recover()
            if is_high and self._echo is _Echo.AWAITED:
                self._risen, self._echo = ticks, _Echo.HIGH
                return
            is_whole = self._echo is _Echo.HIGH and not is_high
            self._echo = _Echo.OVER
            self._judge(self._elapsed(ticks, self._risen) if is_whole else math.nan)
            self.ended.set()

    def fail(self, error: Exception) -> None:
        """Let the sensor fail, until it is heard again."""
        with self._lock:
            self._fail(error)

    def stop(self) -> None:
        """Take no edge any more."""
        with self._lock:
            self._echo = _Echo.OVER

    def _judge(self, pulse: float) -> None:
        """Tell what a pulse of that many seconds says; it is NaN where an edge of it is missing."""
        self._silent = self._silent + 1 if SILENCE_S <= pulse <= STUCK_S else 0
        distance = pulse * self._acoustics.speed / 2
        if 0 <= distance <= self._acoustics.max_range:
            self._tell(max(distance, self._acoustics.min_range))
        elif 0 <= pulse <= LONGEST_ECHO_S or 0 < self._acoustics.echo_free_cycles <= self._silent:
            self._tell(math.inf)

    def _tell(self, distance: float) -> None:
        self._last = Range(distance, self._time, self._last.sequence + 1 if self._last else 0)
        self._is_failed, self.has_told = False, True
        self.newest.put(self._last)

    def _fail(self, error: Exception) -> None:
        self._is_failed = self.has_told = True
        self.newest.fail(error)

    def _recover(self) -> None:
        """Take a fault back: the newest sample is the one before it, and as old as it is."""
        if self._is_failed and self._last:
            self._is_failed = False
            self.newest.put(self._last)


_NOTHING_YET = (
    "has heard nothing that could be judged; hold something flat in front of it. "
    "Where nothing is in range when it is opened, echo_free_cycles must not be 0"
)
_UNANSWERED = "does not answer its trigger; look at its 5 V and its ground, and whether trigger and echo are swapped"
_STUCK = "its echo stays high; look at the wire and the divider at echo, and switch its 5 V off and on again"
