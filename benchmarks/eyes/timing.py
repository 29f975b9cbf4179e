"""Measure the times of finders. Their unit is the time of copying the frame, which depends less on the machine."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sequence
from functools import partial
from time import perf_counter
from typing import NamedTuple

import numpy as np

from benchmarks.eyes.frames import LabelledFrame
from benchmarks.eyes.scoring import Finder
from robotcore.hal.devices import Image

IN_CACHE = 5
"""The number of calls for each cached frame. The fastest call counts."""


class Interval(NamedTuple):
    """A median, and its 95 % interval by order statistics."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, values: Sequence[float]) -> Interval:
        """Return the interval of the median of these values."""
        ordered, half = sorted(values), 1.96 * math.sqrt(len(values)) / 2
        low, high = math.floor(len(ordered) / 2 - half), math.ceil(len(ordered) / 2 + half)
        return cls(statistics.median(ordered), ordered[max(0, low)], ordered[min(len(ordered) - 1, high)])


def measure_copies(finder: Finder, frames: Sequence[LabelledFrame], *, in_cache: bool) -> tuple[Interval, float]:
    """Return the time of a call, in copies of a frame, and the median time of a call in seconds.

    Call and copy are measured in alternating order. With ``in_cache``, both are repeated on each frame. Otherwise each
    frame is used once, as a camera delivers it.
    """
    target, repeats = np.empty_like(frames[0].image), IN_CACHE if in_cache else 1
    ratios, calls = [], []
    for number, frame in enumerate(frames):
        works = partial(np.copyto, target), partial(_find, finder, frame.hue)
        order = (0, 1) if number % 2 else (1, 0)
        times = {which: _time_fastest_call(works[which], frame.image, repeats) for which in order}
        ratios.append(times[1] / times[0])
        calls.append(times[1])
    return Interval.of(ratios), statistics.median(calls)


def _find(finder: Finder, hue: float, image: Image) -> None:
    finder(image, hue)


def _time_fastest_call(work: Callable[[Image], object], image: Image, repeats: int) -> float:
    return min(_once(work, image) for _ in range(repeats))


def _once(work: Callable[[Image], object], image: Image) -> float:
    start = perf_counter()
    work(image)
    return perf_counter() - start
