"""Compare two durations on a busy machine: measure them in pairs, and compute medians with intervals."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sequence


def paired_ratios(first: Callable[[], float], second: Callable[[], float], pairs: int) -> tuple[float, float, float]:
    """Return the median of ``first() / second()``, and its 95 % interval.

    first: a function that measures a duration in seconds.
    second: the function that measures the other duration.

    The two functions of a pair are called right after each other, in alternating order. So other load on the machine
    affects both.
    """
    ratios = []
    for pair in range(pairs):
        if pair % 2:
            below = second()
            ratios.append(first() / below)
        else:
            above = first()
            ratios.append(above / second())
    return median_with_interval(ratios)


def median_with_interval(values: Sequence[float]) -> tuple[float, float, float]:
    """Return the median, and the ends of its 95 % interval, which are two of the values.

    The number of values below the true median is binomial with p = 1/2 (the sign test). With less than six values, no
    interval is so certain. The function then returns the least and the greatest value.

    >>> median_with_interval([3.0, 1.0, 2.0, 5.0, 4.0, 6.0])
    (3.5, 1.0, 6.0)
    """
    ordered = sorted(values)
    outside = _outside(len(ordered))
    return statistics.median(ordered), ordered[outside], ordered[-1 - outside]


def _outside(count: int) -> int:
    """Return how many values at each end of ``count`` sorted ones are outside of the 95 % interval."""
    left_out, below = 0, 1.0
    while 40 * below <= 2**count:
        left_out += 1
        below += math.comb(count, left_out)
    return max(left_out - 1, 0)
