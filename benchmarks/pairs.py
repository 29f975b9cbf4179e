"""How much one thing differs from another on a machine that is never quiet: measured in pairs."""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Sequence


def paired_ratios(first: Callable[[], float], second: Callable[[], float], pairs: int) -> tuple[float, float, float]:
    """Return the median of ``first() / second()`` and the 95 % interval of it.

    Both of a pair are measured right after each other, and take turns in going first, so that what else the machine
    does falls on both alike.
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
    """Return the median, and the narrowest pair of values around it that hold it in 95 of 100 repetitions.

    The number of values below the true median is binomial with p = 1/2 (the sign test); below six values no pair is
    that sure, and the interval is from the least to the greatest.
    """
    ordered = sorted(values)
    outside = _outside(len(ordered))
    return statistics.median(ordered), ordered[outside], ordered[-1 - outside]


def _outside(count: int) -> int:
    """Return how many values at either end can be left out, their probability being at most 2.5 %."""
    left_out, below = 0, 1.0
    while 40 * below <= 2**count:
        left_out += 1
        below += math.comb(count, left_out)
    return max(left_out - 1, 0)
