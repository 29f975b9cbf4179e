"""Series: the runs of one backend in one world, with times and style for charts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from robotcore.sweep.record import GroupKey, Record
from robotcore.sweep.statistics import Group, group_records


@dataclass(frozen=True)
class Series:
    """The runs of one backend in one world, with the style of their curves in charts."""

    group: Group
    """The counts and times of the runs."""

    records: tuple[Record, ...]
    """The records of the runs."""

    style: str = ""
    """The CSS classes of the series: ``c0`` … for the colour, ``d0`` … for the dashes."""

    def list_times(self, milestone: str) -> list[float]:
        """Return the times at which runs reached a milestone, sorted, in seconds since the start of the run."""
        times = (record.result.milestones.get(milestone) for record in self.records)
        return sorted(time for time in times if time is not None)

    def compute_quantiles(self, milestone: str) -> list[float]:
        """Return the 10 %, 50 % and 90 % quantile of `list_times`; an empty list if no run reached the milestone."""
        times = self.list_times(milestone)
        return [float(time) for time in np.quantile(times, (0.1, 0.5, 0.9))] if times else []


def build_series(records: Iterable[Record]) -> list[Series]:
    """Return a series for each backend in each world, first by world, then by backend.

    Worlds and backends are in the order of their first records. Each world has its own colour, and each backend its own
    dashes. If there is only one world, each backend also has its own colour.
    """
    gathered: dict[GroupKey, list[Record]] = {}
    for record in records:
        gathered.setdefault(GroupKey.from_record(record), []).append(record)
    backends, worlds = (list(dict.fromkeys(names)) for names in zip(*gathered, strict=True)) if gathered else ([], [])
    return [
        Series(group_records(gathered[key])[0], tuple(gathered[key]), f"c{hue} d{dashes}")
        for row, world in enumerate(worlds)
        for dashes, backend in enumerate(backends)
        for hue in [row if len(worlds) > 1 else dashes]
        if (key := GroupKey(backend, world)) in gathered
    ]


def list_milestones(series: Sequence[Series]) -> list[str]:
    """Return the milestones that any run reached, in the order of their median times."""
    names = dict.fromkeys(name for each in series for record in each.records for name in record.result.milestones)
    times = {name: [time for each in series for time in each.list_times(name)] for name in names}
    return sorted(names, key=lambda name: float(np.median(times[name])))


def find_goal(series: Sequence[Series], milestones: Sequence[str]) -> str | None:
    """Return the milestone that most passing runs reach last. If no run passed, return the last of ``milestones``.

    Return None if every milestone was reached at 0 s.
    """
    if not any(time > 0 for each in series for name in milestones for time in each.list_times(name)):
        return None
    passing = (record.result.milestones for each in series for record in each.records if not record.is_failure)
    ends = Counter(list(reached)[-1] for reached in passing if reached)
    return next((name for name, _ in ends.most_common(1)), milestones[-1])
