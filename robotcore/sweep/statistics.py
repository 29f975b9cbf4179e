"""What a sweep's runs add up to."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from robotcore.runtime.outcome import Outcome
from robotcore.sweep.place import Place
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
    """The runs of one backend in one world; ``world`` is empty where a backend has none.

    A run passes where it is not failing. ``successes`` are the app's word, ``verified`` the simulator's. ``contacts``
    were counted but for ``untold`` runs, of which nobody knows. ``verified`` and ``contacts`` are None where no run
    could tell. Half of all runs pass within ``median_time_s``, 90 % within ``p90_time_s``, all of them within
    ``slowest_time_s``, on the robot's clock; None where fewer ever do. So no run that hangs or fails at once makes a
    group faster.
    """

    backend: str
    world: str
    runs: int
    failing: int
    successes: int
    verified: int | None
    contacts: int | None
    untold: int
    median_time_s: float | None
    p90_time_s: float | None
    slowest_time_s: float | None

    @property
    def name(self) -> str:
        return f"{self.world} · {self.backend}" if self.world else self.backend

    @property
    def verified_share(self) -> float | None:
        return None if self.verified is None else self.verified / self.runs

    @property
    def verified_95(self) -> tuple[float, float] | None:
        """The 95 % interval of the verified share."""
        return None if self.verified is None else wilson(self.verified, self.runs)

    @property
    def success_share(self) -> float:
        return self.successes / self.runs


def grouped(records: Iterable[Record]) -> list[Group]:
    """Return what each backend did in each world, in the order of their names."""
    tallies: dict[Place, Tally] = {}
    for record in records:
        tallies.setdefault(Place.of(record), Tally()).add(record)
    return [tally.group(place) for place, tally in sorted(tallies.items())]


class Tally:
    """Adds up the records of one place without keeping them."""

    def __init__(self) -> None:
        self._successes = self._untold = 0
        self._verified: int | None = None
        self._contacts: int | None = None
        self._times: list[float] = []
        """When each run passed; infinite for one that did not."""

    def add(self, record: Record) -> None:
        """Count a run."""
        result = record.result
        self._successes += result.outcome is Outcome.SUCCESS
        self._times.append(math.inf if record.is_failure else result.sim_time_s)
        if result.verified is not None:
            self._verified = (self._verified or 0) + result.verified
        if result.contacts is None:
            self._untold += 1
        else:
            self._contacts = (self._contacts or 0) + result.contacts

    def group(self, place: Place) -> Group:
        """Return what the runs came to; there is at least one."""
        times = sorted(self._times)
        return Group(
            *place,
            runs=len(times),
            failing=times.count(math.inf),
            successes=self._successes,
            verified=self._verified,
            contacts=self._contacts,
            untold=self._untold,
            median_time_s=_finite(_median(times)),
            p90_time_s=_finite(times[math.ceil(0.9 * len(times)) - 1]),
            slowest_time_s=_finite(times[-1]),
        )


def _median(times: Sequence[float]) -> float:
    """Return the middle time; the earlier of two where only half of the runs pass."""
    middle = statistics.median(times)
    return middle if math.isfinite(middle) else statistics.median_low(times)


def _finite(time: float) -> float | None:
    return time if math.isfinite(time) else None
