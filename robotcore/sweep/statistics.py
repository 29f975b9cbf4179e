"""What a sweep's runs add up to."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable
from dataclasses import dataclass

from robotcore.outcome import Outcome
from robotcore.sweep.record import Record

Z_95 = 1.959964
"""The standard normal distribution has 95 % within so many standard deviations."""


def wilson(successes: int, n: int) -> tuple[float, float]:
    """Return the 95 % score interval of a proportion; (0, 1) where nothing was tried.

    E. B. Wilson, Probable inference, the law of succession, and statistical inference, Journal of the American
    Statistical Association 22 (1927), 209-212.
    """
    if n == 0:
        return 0.0, 1.0
    share, z2 = successes / n, Z_95**2
    centre = share + z2 / (2 * n)
    reach = Z_95 * math.sqrt(share * (1 - share) / n + z2 / (4 * n * n))
    low, high = (centre - reach) / (1 + z2 / n), (centre + reach) / (1 + z2 / n)
    return (0.0 if successes == 0 else low), (1.0 if successes == n else high)


@dataclass(frozen=True)
class Group:
    """The runs of one backend in one world; ``verified`` and ``contacts`` are None where no run could tell.

    Times are in seconds.
    """

    backend: str
    world: str
    runs: int
    successes: int
    verified: int | None
    contacts: int | None
    median_time: float
    slowest_time: float

    @property
    def verified_share(self) -> float | None:
        return None if self.verified is None else self.verified / self.runs

    @property
    def verified_95(self) -> tuple[float, float] | None:
        """The 95 % interval of the share."""
        return None if self.verified is None else wilson(self.verified, self.runs)

    @property
    def success_share(self) -> float:
        return self.successes / self.runs


def grouped(records: Iterable[Record]) -> list[Group]:
    """Return what each backend did in each world, in the order of their names."""
    tallies: dict[tuple[str, str], _Tally] = {}
    for record in records:
        result = record.result
        tallies.setdefault((result.backend, result.world or ""), _Tally()).add(record)
    return [tally.group(*names) for names, tally in sorted(tallies.items())]


class _Tally:
    """Adds up records without keeping them."""

    def __init__(self) -> None:
        self._successes = 0
        self._verified: int | None = None
        self._contacts: int | None = None
        self._times: list[float] = []

    def add(self, record: Record) -> None:
        result = record.result
        self._successes += result.outcome is Outcome.SUCCESS
        self._times.append(result.sim_time_s)
        if result.verified is not None:
            self._verified = (self._verified or 0) + result.verified
        if result.contacts is not None:
            self._contacts = (self._contacts or 0) + result.contacts

    def group(self, backend: str, world: str) -> Group:
        return Group(
            backend,
            world,
            len(self._times),
            self._successes,
            self._verified,
            self._contacts,
            statistics.median(self._times),
            max(self._times),
        )
