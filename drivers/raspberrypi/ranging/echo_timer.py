"""Convert the echo pulses of an ultrasonic module to samples."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from enum import Enum, auto
from typing import Any

from robotcore.errors import DeviceError
from robotcore.hardware.polled_samples import RangeSampler

LONGEST_ECHO_S = 0.027
"""The longest pulse that counts as an echo, in seconds. The module's range is 4 m, from which an echo takes 26 ms at
−40 °C. Source: HC-SR04 data sheet, ElecFreaks: ranging distance 2 cm to 4 m."""

SILENCE_S = 0.030
"""The shortest pulse that is the module's time-out instead of an echo, in seconds. The time-out is 38 ms by the data
sheet, and up to 200 ms on copies."""

STUCK_S = 0.3
"""If the echo line is high for longer than this many seconds, the module is defective or badly wired."""

UNANSWERED_CYCLES = 5
"""After this many triggers in a row without a pulse, reading the sensor raises an error."""


class _Echo(Enum):
    OVER = auto()
    AWAITED = auto()
    HIGH = auto()


class EchoTimer:
    """Measures the echo pulses of an ultrasonic module by the edges of its echo line.

    A sample needs a whole pulse, both edges after the same trigger. The time of a sample is the time of this trigger.
    Any thread may call `on_edge`.

    device: the sensor's name, for errors.
    sampler: converts measured distances and failures to samples.
    speed: the speed of sound in m/s.
    cycle_s: the time between two triggers.
    elapsed: returns the seconds between two ticks of the pin factory. Its first argument is the later one.
    """

    def __init__(
        self, device: str, sampler: RangeSampler, speed: float, cycle_s: float, elapsed: Callable[[Any, Any], float]
    ) -> None:
        self.ended = threading.Event()
        """Set when the present cycle has its result."""
        self._device, self._sampler, self._speed = device, sampler, speed
        self._cycle_s, self._elapsed = cycle_s, elapsed
        self._lock = threading.Lock()
        self._echo = _Echo.OVER
        self._time = 0.0
        self._triggered: Any = None
        self._risen: Any = None
        self._unanswered = self._waited = 0

    def begin(self, time: float, ticks: Any) -> None:
        """End the previous cycle, and begin a new cycle. The caller sends the trigger afterwards.

        time: the time of the trigger on the robot's clock, in seconds.
        ticks: the same time in ticks of the pin factory.
        """
        with self._lock:
            self._waited = 0
            self._unanswered = self._unanswered + 1 if self._echo is _Echo.AWAITED else 0
            if self._echo is not _Echo.OVER:  # there was no echo, or an edge was lost
                self._sampler.add_unclear()
            if self._unanswered >= UNANSWERED_CYCLES:
                self._sampler.fail(DeviceError(self._device, _UNANSWERED, kind="trigger-unanswered"))
            self._time, self._triggered, self._echo = time, ticks, _Echo.AWAITED
            self.ended.clear()

    def skip_cycle(self) -> None:
        """Count a cycle without a trigger, because the echo line is still high."""
        with self._lock:
            self._waited += 1
            self.ended.clear()
            if self._waited * self._cycle_s > STUCK_S:
                self._echo = _Echo.OVER
                self._sampler.fail(DeviceError(self._device, _STUCK, kind="echo-stuck"))

    def on_edge(self, ticks: Any, is_high: bool) -> None:  # noqa: FBT001  gpiozero passes it by position
        """Process an edge of the echo line. Edges before the trigger and after the pulse are ignored.

        ticks: the time of the edge in ticks of the pin factory.
        is_high: whether the line is high after the edge.
        """
        with self._lock:
            if self._echo is _Echo.OVER or self._elapsed(ticks, self._triggered) < 0:
                return
            self._sampler.clear_failure()
            if is_high and self._echo is _Echo.AWAITED:
                self._risen, self._echo = ticks, _Echo.HIGH
                return
            is_whole = self._echo is _Echo.HIGH and not is_high
            self._echo = _Echo.OVER
            self._add_pulse(self._elapsed(ticks, self._risen) if is_whole else math.nan)
            self.ended.set()

    def fail(self, error: Exception) -> None:
        """Make reads of the sensor raise ``error`` until the next edge of the echo line."""
        with self._lock:
            self._sampler.fail(error)

    def stop(self) -> None:
        """Ignore all further edges."""
        with self._lock:
            self._echo = _Echo.OVER

    def _add_pulse(self, pulse: float) -> None:
        if 0 <= pulse <= LONGEST_ECHO_S:  # NaN: an edge of the pulse is missing
            self._sampler.add_distance(pulse * self._speed / 2, self._time)
        elif SILENCE_S <= pulse <= STUCK_S:
            self._sampler.add_no_echo(self._time)
        else:
            self._sampler.add_unclear()


_UNANSWERED = "does not answer its trigger. Check its 5 V, its ground, and whether trigger and echo are swapped"
_STUCK = "its echo stays high. Check the wire and the divider at echo, and switch its 5 V off and on again"
