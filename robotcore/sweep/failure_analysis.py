"""Failure analysis: which recorded conditions tell failing runs from passing ones."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robotcore.sweep.permutation_test import Floats, Split, Splits, Value, find_best_side, shuffle_failing
from robotcore.sweep.record import GroupKey, Record

SIGNIFICANCE = 0.05

_SEED = 0
_ROUNDING = 1e-9
"""Logarithms of one chance that was reckoned in two ways differ by less."""


@dataclass(frozen=True)
class Finding:
    """The best split of a condition for a backend and world; ``p`` is corrected for all splits that were tried."""

    place: GroupKey
    condition: str
    split: Split
    p: float

    @property
    def where(self) -> str:
        """The side on which more runs fail, such as ``light_brightness < 0.34``."""
        return f"{self.condition} {self.split.sign} {str(self.split.value).removesuffix('.0')}"

    @property
    def shares(self) -> str:
        """How many fail there and how many elsewhere."""
        return f"{self.split.inside}, elsewhere {self.split.outside}"

    def __str__(self) -> str:
        return f"fails more {self.place} where {self.where}: {self.shares}"


@dataclass(frozen=True)
class Explanation:
    """The findings, the best first. Without findings, ``silence`` is the reason; it is empty if no run failed."""

    findings: tuple[Finding, ...]
    silence: str

    @property
    def lines(self) -> list[str]:
        """The lines for a terminal."""
        return [f"{each} ({format_p(each.p)})" for each in self.findings] or [self.silence] * bool(self.silence)


def explain(records: Iterable[Record]) -> Explanation:
    """Return which conditions explain failures, of those runs that tell their conditions.

    The best of many splits looks good by chance too. How good is seen where it is shuffled, within each place, who
    failed: a finding's ``p`` is the share of shuffles whose best split anywhere is as good, and it is listed if
    that is at most 5 %. Splits that are almost the same so count as one, not as many. It is the min-P permutation
    test of P. H. Westfall and S. S. Young, Resampling-Based Multiple Testing (1993), in its single step; the runs as
    they failed count as one shuffle more (B. Phipson and G. K. Smyth, Permutation p-values should never be zero,
    Statistical Applications in Genetics and Molecular Biology 9 (2010), article 39). The shuffles are the same each
    time, in whatever order the runs ended.
    """
    strata = make_strata(records)
    random = np.random.RandomState(_SEED)
    ranked = _rank([test for each in strata if each.is_mixed for test in each.find_splits(random)])
    findings = tuple(each for each in ranked if each.p <= SIGNIFICANCE)
    return Explanation(findings, "" if findings else _explain_silence(strata, ranked))


def format_p(p: float) -> str:
    """Return a chance in short, such as ``p = 0.003``."""
    return f"p = {p:.2g}"


def _rank(tests: Sequence[ConditionTest]) -> list[Finding]:
    """Return what was tried, the surest first."""
    least = np.min([test.log_p for test in tests], axis=0) if tests else np.empty(0)
    ordered = sorted(tests, key=lambda test: float(test.log_p[0]))
    return [Finding(*each[:3], float(np.mean(least <= each.log_p[0] + _ROUNDING))) for each in ordered]


def _explain_silence(strata: Sequence[Stratum], ranked: Sequence[Finding]) -> str:
    """Return why no condition was found."""
    runs, failing = sum(len(each.cases) for each in strata), sum(each.failing for each in strata)
    counts = f"({runs} runs, {failing} failing)"
    mixed = [each for each in strata if each.is_mixed]
    if not failing:
        return ""
    if not mixed:
        which = "every run" if failing == runs else "in each world on each backend every run or none"
        return f"{which} failed: nothing to compare with {counts}"
    if not ranked:
        return f"no condition differs from run to run {counts}"
    if max(each.permutations for each in mixed) < 1 / SIGNIFICANCE:
        return f"too few runs to tell any condition from chance {counts}"
    nearest = ranked[0]
    near = f"{nearest.where} {nearest.place}, {nearest.shares} ({format_p(nearest.p)})"
    return f"no condition can be told from chance {counts}; nearest: {near}"


class Case(NamedTuple):
    """A run's seed, outcome and conditions."""

    seed: int
    is_failure: bool
    conditions: Mapping[str, Value]


class ConditionTest(NamedTuple):
    """A condition's best split in a place; ``log_p`` has the logarithm of its chance: as runs failed, then shuffled."""

    place: GroupKey
    condition: str
    split: Split
    log_p: Floats


@dataclass(frozen=True)
class Stratum:
    """Comparable runs: same backend, same world, same conditions recorded, in the order of their seeds."""

    place: GroupKey
    cases: Sequence[Case]

    @property
    def failing(self) -> int:
        return sum(case.is_failure for case in self.cases)

    @property
    def is_mixed(self) -> bool:
        """Whether some runs failed and some did not."""
        return 0 < self.failing < len(self.cases)

    @property
    def permutations(self) -> int:
        """In how many ways as many runs could have failed."""
        return math.comb(len(self.cases), self.failing)

    def find_splits(self, random: np.random.RandomState) -> Iterator[ConditionTest]:
        """Yield the best split of each condition that is not the same in all runs."""
        failing = np.flatnonzero([case.is_failure for case in self.cases])
        rows = shuffle_failing(len(self.cases), failing, random)
        for name in self.cases[0].conditions:
            splits = Splits.of([case.conditions[name] for case in self.cases])
            if splits.sides:
                side, least = find_best_side(splits, rows)
                yield ConditionTest(self.place, name, splits.split(side, failing), least)


def make_strata(records: Iterable[Record]) -> list[Stratum]:
    """Return the runs that tell conditions, parted so that only like is compared with like.

    Each backend is looked at in each world by itself: the same seed draws the same conditions for every backend, so
    that its runs are no independent cases, and worlds differ in how often runs fail as they do in what is drawn.
    """
    parted: dict[tuple[GroupKey, tuple[str, ...]], list[Case]] = {}
    for record in records:
        result = record.result
        if result.conditions:
            case = Case(-1 if result.seed is None else result.seed, record.is_failure, result.conditions)
            parted.setdefault((GroupKey.of(record), tuple(sorted(result.conditions))), []).append(case)
    ordered = sorted(parted.items(), key=lambda item: item[0])
    return [Stratum(place, sorted(cases, key=lambda case: case.seed)) for (place, _), cases in ordered]
