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
"""The largest p-value of a finding."""

_SEED = 0
_ROUNDING = 1e-9
"""The tolerance for comparing logarithms. Two computations of the same logarithm differ by less than this."""


@dataclass(frozen=True)
class Finding:
    """The best split of a condition's values into failing and passing runs, for one backend in one world."""

    group: GroupKey
    """The backend and the world of the runs."""

    condition: str
    """The name of the condition."""

    split: Split
    """The split with the least p-value of Fisher's exact test."""

    p: float
    """The p-value, corrected for the number of splits that were tried."""

    @property
    def side(self) -> str:
        """The values with which more runs fail, such as ``light_brightness < 0.34``."""
        return f"{self.condition} {self.split.sign} {str(self.split.value).removesuffix('.0')}"

    @property
    def shares(self) -> str:
        """The number of failing runs with these values, and with all other values."""
        return f"{self.split.inside}, else {self.split.outside}"

    def __str__(self) -> str:
        return f"fails more {self.group} if {self.side}: {self.shares}"


@dataclass(frozen=True)
class Explanation:
    """The result of a failure analysis: the conditions that explain failures."""

    findings: tuple[Finding, ...]
    """The findings, the one with the least p first."""

    reason: str
    """Why there are no findings; empty if there are some, or if no run failed."""

    @property
    def lines(self) -> list[str]:
        """The lines for a terminal."""
        return [f"{each} ({format_p(each.p)})" for each in self.findings] or [self.reason] * bool(self.reason)


def explain(records: Iterable[Record]) -> Explanation:
    """Return the conditions under which more runs fail. Records without conditions do not count.

    The best of many splits looks good by chance too. So the test shuffles which runs of a group failed, again and
    again. A finding's ``p`` is the fraction of permutations whose best split of any condition is at least as good. The
    observed runs count as one permutation. A finding is listed if ``p`` is at most `SIGNIFICANCE`.

    The permutations are the same each time, in whatever order the runs ended.

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
    ['fails more in arena on kinematic if light < 0.5: 8 of 8, else 0 of 20 (p = 0.001)']
    """
    strata = make_strata(records)
    random = np.random.RandomState(_SEED)
    ranked = _rank([test for each in strata if each.is_mixed for test in each.find_splits(random)])
    findings = tuple(each for each in ranked if each.p <= SIGNIFICANCE)
    return Explanation(findings, "" if findings else _find_reason(strata, ranked))


def format_p(p: float) -> str:
    """Return the text for a p-value, such as ``p = 0.003``."""
    return f"p = {p:.2g}"


def _rank(tests: Sequence[ConditionTest]) -> list[Finding]:
    """Return the best split of each condition, the one with the least p first."""
    least = np.min([test.log_p for test in tests], axis=0) if tests else np.empty(0)
    ordered = sorted(tests, key=lambda test: float(test.log_p[0]))
    return [Finding(*each[:3], float(np.mean(least <= each.log_p[0] + _ROUNDING))) for each in ordered]


def _find_reason(strata: Sequence[Stratum], ranked: Sequence[Finding]) -> str:
    """Return why there is no finding; empty if no run failed."""
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
    best = ranked[0]
    return f"no split is significant {counts}; the best: {best.side} {best.group}, {best.shares} ({format_p(best.p)})"


class Case(NamedTuple):
    """The seed, the outcome and the conditions of a run."""

    seed: int
    """The seed; -1 for a run without one."""

    is_failure: bool
    """Whether the run failed."""

    conditions: Mapping[str, Value]
    """The value of each condition."""


class ConditionTest(NamedTuple):
    """The permutation test of one condition in one group."""

    group: GroupKey
    """The backend and the world."""

    condition: str
    """The name of the condition."""

    split: Split
    """The split with the least p-value."""

    log_p: Floats
    """The logarithm of the least p-value in each permutation, the observed one first."""


@dataclass(frozen=True)
class Stratum:
    """A group of comparable runs. They have the same backend and world, and recorded the same conditions."""

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
        """The number of ways to choose the failing runs."""
        return math.comb(len(self.cases), self.failing)

    def find_splits(self, random: np.random.RandomState) -> Iterator[ConditionTest]:
        """Yield the best split of each condition whose value differs between runs."""
        failing = np.flatnonzero([case.is_failure for case in self.cases])
        rows = shuffle_failing(len(self.cases), failing, random)
        for name in self.cases[0].conditions:
            splits = Splits.of([case.conditions[name] for case in self.cases])
            if splits.sides:
                side, least = find_best_side(splits, rows)
                yield ConditionTest(self.group, name, splits.build_split(side, failing), least)


def make_strata(records: Iterable[Record]) -> list[Stratum]:
    """Group the runs that have conditions by backend, world and the names of the conditions.

    Backends are separate: the same seed draws the same conditions for each, so their runs are not independent. Worlds
    are separate: they differ both in the share of failing runs and in the conditions that are drawn.
    """
    cases_by_group: dict[tuple[GroupKey, tuple[str, ...]], list[Case]] = {}
    for record in records:
        result = record.result
        if result.conditions:
            case = Case(-1 if result.seed is None else result.seed, record.is_failure, result.conditions)
            cases_by_group.setdefault((GroupKey.of(record), tuple(sorted(result.conditions))), []).append(case)
    ordered = sorted(cases_by_group.items(), key=lambda item: item[0])
    return [Stratum(group, sorted(cases, key=lambda case: case.seed)) for (group, _), cases in ordered]
