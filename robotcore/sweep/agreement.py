"""Where two backends ran the same seeds: whether they tell the same."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import combinations

from robotcore.runtime.outcome import RunResult
from robotcore.sweep.record import Record

Pair = tuple[RunResult, RunResult]


@dataclass(frozen=True)
class Agreement:
    """Two backends, and every pair of their runs of the same app, robot, world and seed."""

    first: str
    second: str
    pairs: tuple[Pair, ...]

    @property
    def same_outcome(self) -> int:
        return sum(one.outcome is other.outcome for one, other in self.pairs)

    @property
    def same_milestones(self) -> int:
        """How many pairs reached the same milestones in the same order."""
        return sum(list(one.milestones) == list(other.milestones) for one, other in self.pairs)

    @property
    def differing(self) -> tuple[Pair, ...]:
        return tuple(pair for pair in self.pairs if _told(pair[0]) != _told(pair[1]))


def agreements_of(records: Sequence[Record]) -> list[Agreement]:
    """Return what each two backends make of the runs that both did."""
    runs: dict[str, dict[Hashable, RunResult]] = {}
    for record in records:
        runs.setdefault(record.result.backend, {})[_case(record.result)] = record.result
    found = (
        Agreement(
            first,
            second,
            tuple((runs[first][case], runs[second][case]) for case in runs[first] if case in runs[second]),
        )
        for first, second in combinations(runs, 2)
    )
    return [each for each in found if each.pairs]


def _case(result: RunResult) -> Hashable:
    return result.app, result.robot, result.world, result.seed


def _told(result: RunResult) -> tuple[object, ...]:
    return result.outcome, *result.milestones
