"""The percentiles of measured durations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple


class Percentiles(NamedTuple):
    """The median, the 99th percentile and the greatest of measured values.

    >>> print(Percentiles.from_durations([0.001, 0.002, 0.009]))
    p50 2.00 ms, p99 9.00 ms, worst 9.00 ms
    """

    p50: float
    p99: float
    worst: float

    @classmethod
    def from_durations(cls, values: Iterable[float]) -> Percentiles:
        """Return the percentiles of one or more durations in seconds."""
        ordered = sorted(values)
        return cls(_pick(ordered, 0.5), _pick(ordered, 0.99), ordered[-1])

    def __str__(self) -> str:
        return f"p50 {self.p50 * 1e3:.2f} ms, p99 {self.p99 * 1e3:.2f} ms, worst {self.worst * 1e3:.2f} ms"

    @property
    def values(self) -> dict[str, float]:
        """The three numbers in milliseconds, by their names in a report."""
        return {f"{name}_ms": round(value * 1e3, 4) for name, value in self._asdict().items()}


def _pick(ordered: Sequence[float], share: float) -> float:
    return ordered[max(0, math.ceil(share * len(ordered)) - 1)]
