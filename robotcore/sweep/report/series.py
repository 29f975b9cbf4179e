"""The runs of one backend in one world as what is drawn of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from robotcore.sweep.record import GroupKey, Record
from robotcore.sweep.statistics import Group, Tally


@dataclass(frozen=True)
class Series:
    """A group with its runs.

    ``style`` are the CSS classes that tell its curves from others: ``c0`` … for the colour, ``d0`` … for the dashes.
    """

    group: Group
    records: tuple[Record, ...]
    style: str = ""

    def arrivals(self, milestone: str) -> list[float]:
        """Return when each run that reached a milestone did so, in seconds, the earliest first."""
        times = (record.result.milestones.get(milestone) for record in self.records)
        return sorted(time for time in times if time is not None)


@dataclass(frozen=True)
class Spread:
    """Times in seconds: what 10 %, half and 90 % of them stay within."""

    fast: float
    median: float
    slow: float

    @classmethod
    def of(cls, times: Iterable[float]) -> Spread | None:
        """Return the spread of some times; None where there are none."""
        some = list(times)
        return cls(*map(float, np.quantile(some, (0.1, 0.5, 0.9)))) if some else None


def make_series(records: Iterable[Record]) -> list[Series]:
    """Return a series for each group, world by world, in the order in which they occur.

    A world has a colour and a backend its dashes; where there is one world, a backend has a colour too.
    """
    gathered: dict[GroupKey, list[Record]] = {}
    for record in records:
        gathered.setdefault(GroupKey.of(record), []).append(record)
    backends, worlds = (list(dict.fromkeys(names)) for names in zip(*gathered, strict=True)) if gathered else ([], [])
    return [
        Series(_make_group(place, gathered[place]), tuple(gathered[place]), f"c{hue} d{dashes}")
        for row, world in enumerate(worlds)
        for dashes, backend in enumerate(backends)
        for hue in [row if len(worlds) > 1 else dashes]
        if (place := GroupKey(backend, world)) in gathered
    ]


def _make_group(place: GroupKey, records: Iterable[Record]) -> Group:
    tally = Tally()
    for record in records:
        tally.add(record)
    return tally.group(place)


def list_milestones(series: Sequence[Series]) -> list[str]:
    """Return every milestone that was reached, in the order of the median times."""
    names = dict.fromkeys(name for each in series for record in each.records for name in record.result.milestones)
    times = {name: [time for each in series for time in each.arrivals(name)] for name in names}
    return sorted(names, key=lambda name: float(np.median(times[name])))


def find_goal(series: Sequence[Series], milestones: Sequence[str]) -> str | None:
    """Return the milestone that a passing run most often reaches last; where none passed, the latest of all.

    None where no run gets farther than what it reaches at once: that takes no time.
    """
    if not any(time > 0 for each in series for name in milestones for time in each.arrivals(name)):
        return None
    passing = (record.result.milestones for each in series for record in each.records if not record.is_failure)
    ends = Counter(list(reached)[-1] for reached in passing if reached)
    return next((name for name, _ in ends.most_common(1)), milestones[-1])
