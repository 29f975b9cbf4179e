"""The durations of the phases of a run's ticks."""

from __future__ import annotations

import math
from array import array
from threading import Lock
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["PhaseTimes", "TickStatistics"]

LEAST_S = 1e-7
"""The least duration that is distinguished from 0, in seconds."""

RATIO = 1.01
"""The ratio of the limits of a bin. The percentiles are exact to within 0.5 %."""

BINS = 2320
"""The number of bins of a histogram. The last bin has the durations from 1,000 s."""

BATCH = 1000
"""The number of ticks whose durations are added to the histograms together."""


class PhaseTimes(NamedTuple):
    """The durations of the phases of one tick, in seconds. Their sum is the duration of the tick.

    >>> from robotcore.runtime.tick_statistics import PhaseTimes
    >>> times = PhaseTimes(read=0.001, decide=0.002, guard=0.0, commit=0.0, record=0.0, sleep=0.047)
    >>> round(sum(times), 6)
    0.05
    """

    read: float
    """The reads of sensors, also those that the app, the odometry and the range guard cause."""
    decide: float
    """The app's step, without reads, rules and commands."""
    guard: float
    """The rules of the safety stage, such as the range guard."""
    commit: float
    """The commands to motors and other actuators."""
    record: float
    """The observers of the run, such as the recorder."""
    sleep: float
    """The time until the next tick. A simulator takes its steps then. A pause does not count."""


_BATCH_NUMBERS = BATCH * len(PhaseTimes._fields)


class TickStatistics:
    """Histograms of the durations of the phases of a run's ticks.

    The time of a sensor's read belongs to ``read``, though it happens in the app's step. Only ticks that have ended
    with their sleep count.

    >>> from robotcore.runtime.tick_statistics import PhaseTimes, TickStatistics
    >>> statistics = TickStatistics()
    >>> statistics.add(PhaseTimes(0.001, 0.002, 0.0, 0.0, 0.0, 0.047))
    >>> statistics.summarise()["decide"]
    {'p50': 2000.0, 'p99': 2000.0, 'worst': 2000.0}
    """

    def __init__(self) -> None:
        self._batch: list[float] = []
        self._counts = np.zeros((len(PhaseTimes._fields), BINS), np.int64)
        self._worst = np.zeros(len(PhaseTimes._fields))
        self._lock = Lock()

    def add(self, times: tuple[float, float, float, float, float, float]) -> None:
        """Add the durations of a tick in seconds, in the order of `PhaseTimes`."""
        self._batch += times
        if len(self._batch) >= _BATCH_NUMBERS:
            with self._lock:
                self._counts, self._worst = self._count()
                self._batch.clear()

    def summarise(self) -> dict[str, dict[str, float]]:
        """Return ``p50``, ``p99`` and ``worst`` of each phase in microseconds. Any thread may call this.

        The result is empty before the end of the first tick.
        """
        with self._lock:
            counts, worst = self._count()
        ticks = int(counts[0].sum())
        if not ticks:
            return {}
        ranks = [math.ceil(0.5 * ticks), math.ceil(0.99 * ticks)]
        return {
            phase: {
                **{
                    name: _round_us(min(LEAST_S * RATIO ** (place + 0.5), greatest))
                    for name, place in zip(("p50", "p99"), np.searchsorted(np.cumsum(count), ranks), strict=True)
                },
                "worst": _round_us(greatest),
            }
            for phase, count, greatest in zip(PhaseTimes._fields, counts, worst.tolist(), strict=True)
        }

    def _count(self) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the counts and the greatest durations, with those of the batch."""
        durations = np.frombuffer(array("d", self._batch)).reshape(-1, len(self._worst))  # `np.array` takes longer
        bins = np.log(np.maximum(durations, LEAST_S) / LEAST_S) / math.log(RATIO)
        places = np.minimum(bins.astype(np.int64), BINS - 1) + np.arange(len(self._worst)) * BINS
        counts = np.bincount(places.ravel(), minlength=self._counts.size).reshape(self._counts.shape)
        return self._counts + counts, np.maximum(self._worst, durations.max(axis=0, initial=0.0))


def _round_us(seconds: float) -> float:
    return round(seconds * 1e6, 1)
