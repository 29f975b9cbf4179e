"""Runs among which chance could have let any other one fail."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robotcore.sweep.fisher import Floats
from robotcore.sweep.place import Place
from robotcore.sweep.record import Record
from robotcore.sweep.shuffling import best_side, shuffled
from robotcore.sweep.splits import Split, Splits, Value


class Case(NamedTuple):
    """A run as far as it matters here."""

    seed: int
    is_failure: bool
    conditions: Mapping[str, Value]


class Trial(NamedTuple):
    """A condition's best split in a place; ``least`` has the logarithm of its chance: as runs failed, then shuffled."""

    place: Place
    condition: str
    split: Split
    least: Floats


@dataclass(frozen=True)
class Stratum:
    """The runs of a place that tell the same conditions, in the order of their seeds."""

    place: Place
    cases: Sequence[Case]

    @property
    def failing(self) -> int:
        return sum(case.is_failure for case in self.cases)

    @property
    def is_mixed(self) -> bool:
        """Whether some runs failed and some did not."""
        return 0 < self.failing < len(self.cases)

    @property
    def ways(self) -> int:
        """In how many ways as many runs could have failed."""
        return math.comb(len(self.cases), self.failing)

    def trials(self, random: np.random.RandomState) -> Iterator[Trial]:
        """Yield the best split of each condition that is not the same in all runs."""
        failing = np.flatnonzero([case.is_failure for case in self.cases])
        rows = shuffled(len(self.cases), failing, random)
        for name in self.cases[0].conditions:
            splits = Splits.of([case.conditions[name] for case in self.cases])
            if splits.sides:
                side, least = best_side(splits, rows)
                yield Trial(self.place, name, splits.split(side, failing), least)


def strata_of(records: Iterable[Record]) -> list[Stratum]:
    """Return the runs that tell conditions, parted so that only like is compared with like.

    Each backend is looked at in each world by itself: the same seed draws the same conditions for every backend, so
    that its runs are no independent cases, and worlds differ in how often runs fail as they do in what is drawn.
    """
    parted: dict[tuple[Place, tuple[str, ...]], list[Case]] = {}
    for record in records:
        result = record.result
        if result.conditions:
            case = Case(-1 if result.seed is None else result.seed, record.is_failure, result.conditions)
            parted.setdefault((Place.of(record), tuple(sorted(result.conditions))), []).append(case)
    ordered = sorted(parted.items(), key=lambda item: item[0])
    return [Stratum(place, sorted(cases, key=lambda case: case.seed)) for (place, _), cases in ordered]
