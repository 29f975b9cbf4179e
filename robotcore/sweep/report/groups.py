"""The runs of one backend in one world, and what they come to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robotcore.outcome import Outcome
from robotcore.sweep.record import Record
from robotcore.sweep.statistics import wilson


@dataclass(frozen=True)
class Group:
    """The runs of one backend in one world; ``world`` is empty where a backend has none.

    ``style`` are the CSS classes that tell its curves from others: ``c0`` … for the colour, ``d0`` … for the dashes.
    """

    backend: str
    world: str
    records: tuple[Record, ...]
    style: str = ""

    @property
    def name(self) -> str:
        return f"{self.world} · {self.backend}" if self.world else self.backend

    @property
    def runs(self) -> int:
        return len(self.records)

    @cached_property
    def is_judged(self) -> bool:
        """Whether a simulator gave its word on any of the runs; else the app's own word counts."""
        return any(record.result.verified is not None for record in self.records)

    @cached_property
    def successes(self) -> int:
        """How many runs are verified, or say that they succeeded where nobody can judge."""
        if self.is_judged:
            return sum(record.result.verified is True for record in self.records)
        return sum(record.result.outcome is Outcome.SUCCESS for record in self.records)

    @property
    def share(self) -> float:
        return self.successes / self.runs

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the share."""
        return wilson(self.successes, self.runs)

    @cached_property
    def failing(self) -> int:
        return sum(record.is_failure for record in self.records)

    @property
    def contacts(self) -> int | None:
        """Touches in all runs together; None where no run can tell."""
        told = [record.result.contacts for record in self.records if record.result.contacts is not None]
        return sum(told) if told else None

    @cached_property
    def spread(self) -> Spread | None:
        """How long the runs took that did not fail."""
        return Spread.of(record.result.sim_time_s for record in self.records if not record.is_failure)

    def arrivals(self, milestone: str) -> list[float]:
        """Return when each run that reached a milestone did so, in seconds, the earliest first."""
        told = (record.result.milestones.get(milestone) for record in self.records)
        return sorted(time for time in told if time is not None)


@dataclass(frozen=True)
class Spread:
    """Times in seconds: what 10 %, half, 90 % and all of them stay within."""

    fast: float
    median: float
    slow: float
    slowest: float

    @classmethod
    def of(cls, times: Iterable[float]) -> Spread | None:
        """Return the spread of some times; None where there are none."""
        some = list(times)
        return cls(*map(float, np.quantile(some, (0.1, 0.5, 0.9, 1.0)))) if some else None


def groups_of(records: Iterable[Record]) -> list[Group]:
    """Return the groups, world by world, in the order in which they occur.

    A world has a colour and a backend its dashes; where there is one world, a backend has a colour too.
    """
    gathered: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        gathered.setdefault((record.result.world or "", record.result.backend), []).append(record)
    worlds, backends = (list(dict.fromkeys(names)) for names in zip(*gathered, strict=True)) if gathered else ([], [])
    return [
        Group(backend, world, tuple(gathered[world, backend]), f"c{hue} d{dashes}")
        for row, world in enumerate(worlds)
        for dashes, backend in enumerate(backends)
        for hue in [row if len(worlds) > 1 else dashes]
        if (world, backend) in gathered
    ]


def milestones_of(groups: Sequence[Group]) -> list[str]:
    """Return every milestone that was reached, in the order of the median times."""
    names = dict.fromkeys(name for group in groups for record in group.records for name in record.result.milestones)
    times = {name: [time for group in groups for time in group.arrivals(name)] for name in names}
    return sorted(names, key=lambda name: float(np.median(times[name])))


def goal_of(groups: Sequence[Group], milestones: Sequence[str]) -> str | None:
    """Return the milestone that a passing run most often reaches last; where none passed, the latest of all."""
    passing = (record.result.milestones for group in groups for record in group.records if not record.is_failure)
    ends = Counter(list(reached)[-1] for reached in passing if reached)
    return next((name for name, _ in ends.most_common(1)), milestones[-1] if milestones else None)
