"""Failure analysis: find the recorded conditions under which more runs fail."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robotcore.sweep.permutation_test import Floats, Split, Splits, Value, find_best_side, shuffle_failing
from robotcore.sweep.record import GroupKey, Record

SIGNIFICANCE = 0.05
"""The largest corrected p-value of a significant split."""

_SEED = 0
_ROUNDING = 1e-9
"""The tolerance for comparing logarithms of p-values. Two computations of the same p-value differ by less."""


@dataclass(frozen=True)
class SignificantSplit:
    """A condition under which significantly more runs fail, for one backend in one world."""

    group: GroupKey
    """The backend and the world of the runs."""

    condition: str
    """The name of the condition."""

    split: Split
    """The condition's split with the least p-value of Fisher's exact test."""

    p: float
    """The p-value of the permutation test. It takes into account how many splits were tried."""

    @property
    def side(self) -> str:
        """The values of the condition with which more runs fail, such as ``light_brightness < 0.34``."""
        return self.split.format_comparison(self.condition)

    def __str__(self) -> str:
        return f"more runs fail {self.group} if {self.side}: {self.split.shares}"


@dataclass(frozen=True)
class Explanation:
    """The result of a failure analysis: the significant splits, or the reason why there are none."""

    splits: tuple[SignificantSplit, ...]
    """The significant splits, the one with the least p-value first. A condition has at most one for each group."""

    reason: str
    """Why no split is significant. It is empty if some split is significant, or if no run failed."""

    @property
    def lines(self) -> list[str]:
        """The lines that the terminal shows: the significant splits, else the reason."""
        return [f"{each} ({format_p(each.p)})" for each in self.splits] or [self.reason] * bool(self.reason)


def explain(records: Iterable[Record]) -> Explanation:
    """Return the conditions under which more runs fail. Records without conditions are ignored.

    Even if no condition matters, the best of many splits looks good by chance. So the test shuffles which runs of a
    group failed, `SHUFFLES` times. The ``p`` of a split is the fraction of permutations in which the best split of any
    condition is at least as good. The observed runs count as one permutation. The result has each split whose ``p`` is
    at most `SIGNIFICANCE`.

    The result does not depend on the order of the records, because the shuffles have a fixed seed.

    Method: the single-step min-P test of P. H. Westfall and S. S. Young, Resampling-Based Multiple Testing (1993).
    Counting the observed runs: B. Phipson and G. K. Smyth, Permutation p-values should never be zero, Statistical
    Applications in Genetics and Molecular Biology 9 (2010), article 39.

    >>> from robotcore import Outcome, RunResult
    >>> def run(light: float, outcome: Outcome) -> Record:
    ...     result = RunResult("search", "kinematic", "rover", "arena", 1, outcome, 0, conditions={"light": light})
    ...     return Record(result, None, "robotcore run search")
    >>> dark = [run(0.2, Outcome.FAILURE) for _ in range(8)]
    >>> bright = [run(0.8, Outcome.SUCCESS) for _ in range(20)]
    >>> explain(dark + bright).lines
    ['more runs fail in arena on kinematic if light < 0.5: 8 of 8, else 0 of 20 (p = 0.001)']
    """
    strata = make_strata(records)
    random = np.random.RandomState(_SEED)
    ranked = _compute_p_values([test for each in strata if each.is_mixed for test in each.test_conditions(random)])
    splits = tuple(SignificantSplit(*test[:3], p) for p, test in ranked if p <= SIGNIFICANCE)
    return Explanation(splits, "" if splits else _find_reason(strata, ranked))


def format_p(p: float) -> str:
    """Return a p-value as text, such as ``p = 0.003``."""
    return f"p = {p:.2g}"


def _compute_p_values(tests: Sequence[ConditionTest]) -> list[tuple[float, ConditionTest]]:
    """Return each test with its corrected p-value, the least first. The correction covers all splits of all tests."""
    least = np.min([test.log_p for test in tests], axis=0) if tests else np.empty(0)
    ordered = sorted(tests, key=lambda test: float(test.log_p[0]))
    return [(float(np.mean(least <= test.log_p[0] + _ROUNDING)), test) for test in ordered]


def _find_reason(strata: Sequence[Stratum], ranked: Sequence[tuple[float, ConditionTest]]) -> str:
    runs, failing = sum(len(each.cases) for each in strata), sum(each.failing for each in strata)
    counts = f"({runs} runs, {failing} failing)"
    mixed = [each for each in strata if each.is_mixed]
    if not failing:
        return ""
    if not mixed:
        which = "every run" if failing == runs else "in each world on each backend, every run or none"
        return f"{which} failed, so there is nothing to compare {counts}"
    if not ranked:
        return f"every condition has the same value in all runs {counts}"
    if max(each.permutations for each in mixed) < 1 / SIGNIFICANCE:
        return f"too few runs for a significant split {counts}"
    p, best = ranked[0]
    side, shares = best.split.format_comparison(best.condition), best.split.shares
    return f"no split is significant {counts}; the best: {side} {best.group}, {shares} ({format_p(p)})"


class Case(NamedTuple):
    """The seed, the outcome and the conditions of a run."""

    seed: int
    """The seed; -1 for a run without a seed."""

    is_failure: bool
    """Whether the run failed."""

    conditions: Mapping[str, Value]
    """The values of the conditions by name."""


class ConditionTest(NamedTuple):
    """The permutation test of one condition, for one backend in one world."""

    group: GroupKey
    """The backend and the world."""

    condition: str
    """The name of the condition."""

    split: Split
    """The split with the least p-value of Fisher's exact test."""

    log_p: Floats
    """The logarithm of the least p-value in each permutation. The first entry is of the observed runs."""


@dataclass(frozen=True)
class Stratum:
    """Comparable runs: those of one backend in one world that recorded the same conditions."""

    group: GroupKey
    """The backend and the world."""

    cases: Sequence[Case]
    """The runs, in the order of their seeds."""

    @property
    def failing(self) -> int:
        """The number of failing runs."""
        return sum(case.is_failure for case in self.cases)

    @property
    def is_mixed(self) -> bool:
        """Whether some runs failed and some passed."""
        return 0 < self.failing < len(self.cases)

    @property
    def permutations(self) -> int:
        """The number of ways in which as many runs of this stratum could fail."""
        return math.comb(len(self.cases), self.failing)

    def test_conditions(self, random: np.random.RandomState) -> Iterator[ConditionTest]:
        """Yield the test of each condition whose value is not the same in all runs.

        random: the random generator of the shuffles.
        """
        failing = np.flatnonzero([case.is_failure for case in self.cases])
        rows = shuffle_failing(len(self.cases), failing, random)
        for name in self.cases[0].conditions:
            splits = Splits.of([case.conditions[name] for case in self.cases])
            if splits.sides:
                side, least = find_best_side(splits, rows)
                yield ConditionTest(self.group, name, splits.build_split(side, failing), least)


def make_strata(records: Iterable[Record]) -> list[Stratum]:
    """Return the runs that have conditions, grouped by backend, world and the names of the conditions.

    Runs of different backends are not independent, because a seed draws the same conditions for each backend. Worlds
    differ in their share of failing runs and in the conditions that are drawn, so a world could look like a cause.
    """
    cases_by_group: dict[tuple[GroupKey, tuple[str, ...]], list[Case]] = {}
    for record in records:
        result = record.result
        if result.conditions:
            case = Case(-1 if result.seed is None else result.seed, record.is_failure, result.conditions)
            cases_by_group.setdefault((GroupKey.of(record), tuple(sorted(result.conditions))), []).append(case)
    ordered = sorted(cases_by_group.items(), key=lambda item: item[0])
    return [Stratum(group, sorted(cases, key=lambda case: case.seed)) for (group, _), cases in ordered]
