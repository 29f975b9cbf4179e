"""Failure analysis: find the recorded conditions under which more runs fail."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

from robotcore.sweep.record import GroupKey, Record
from robotcore.text import pluralize

SIGNIFICANCE = 0.05
"""The largest corrected p-value of a significant split."""

PARTS = 10
"""The thresholds of a number divide the runs into at most so many parts. More thresholds weaken each test."""

_ROUNDING = 1e-7
"""The tolerance for comparing logarithms of probabilities. Two computations of the same one differ by less."""


class FailureCount(NamedTuple):
    """The number of runs on one side of a split, and how many of them failed."""

    failing: int
    runs: int

    def __str__(self) -> str:
        return f"{self.failing} of {self.runs}"


@dataclass(frozen=True)
class Split:
    """A split of the runs of one backend in one world by one condition."""

    group: GroupKey
    """The backend and the world of the runs."""

    condition: str
    """The name of the condition."""

    sign: str
    """The comparison that is true on the side with more failing runs: ``<``, ``≥``, ``=`` or ``≠``."""

    value: float | str
    """The value that the condition is compared with: a threshold or a word."""

    inside: FailureCount
    """The runs for which the comparison is true."""

    outside: FailureCount
    """The runs for which the comparison is false."""

    p: float
    """The p-value of Fisher's exact test. `explain` returns it corrected for the number of tests."""

    @property
    def side(self) -> str:
        """The values of the condition with which more runs fail, such as ``light_brightness < 0.34``."""
        return f"{self.condition} {self.sign} {str(self.value).removesuffix('.0')}"

    @property
    def shares(self) -> str:
        """How many runs fail on both sides, such as ``7 of 12, else 3 of 188``."""
        return f"{self.inside}, else {self.outside}"

    def __str__(self) -> str:
        return f"more runs fail {self.group} if {self.side}: {self.shares}"


class Explanation(NamedTuple):
    """The result of a failure analysis: the significant splits, or the reason why there are none."""

    splits: tuple[Split, ...]
    """The significant splits, the one with the least p-value first. A condition has at most one for each group."""

    reason: str
    """Why no split is significant. It is empty if some split is significant, or if no run failed."""

    @property
    def lines(self) -> list[str]:
        """The lines that the terminal shows: the significant splits, else the reason."""
        return [f"{each} ({format_p(each.p)})" for each in self.splits] or [self.reason] * bool(self.reason)


def explain(records: Iterable[Record]) -> Explanation:
    """Return the conditions under which more runs fail. Records without conditions are ignored.

    Fisher's exact test compares both sides of each split. A number is split at up to nine thresholds. Each word is
    split from all others, and two words are one split. The p-values are corrected for the number of tests by Holm's
    method. So if no condition matters, the result has a split in at most one of twenty sweeps.

    S. Holm, A simple sequentially rejective multiple test procedure, Scandinavian Journal of Statistics 6 (1979).

    >>> from robotcore import Outcome, RunResult
    >>> def run(light: float, outcome: Outcome) -> Record:
    ...     result = RunResult("search", "kinematic", "rover", "arena", 1, outcome, 0, conditions={"light": light})
    ...     return Record(result, None, "robotcore run search")
    >>> dark = [run(0.2, Outcome.FAILURE) for _ in range(8)]
    >>> bright = [run(0.8, Outcome.SUCCESS) for _ in range(20)]
    >>> explain(dark + bright).lines
    ['more runs fail in arena on kinematic if light < 0.5: 8 of 8, else 0 of 20 (p < 0.001)']
    """
    strata = _make_strata(records)
    ranked = _correct(each for stratum in strata for each in _split_runs(*stratum))
    best: dict[tuple[GroupKey, str], Split] = {}
    for split in ranked:
        best.setdefault((split.group, split.condition), split)
    significant = [split for split in best.values() if split.p <= SIGNIFICANCE]
    return Explanation(tuple(significant), "" if significant else _find_reason(strata, ranked))


def format_p(p: float) -> str:
    """Return a p-value as text, such as ``p = 0.003`` or ``p < 0.001``."""
    return "p < 0.001" if p < 0.001 else f"p = {p:.2g}"


def compute_fisher_p(inside: FailureCount, outside: FailureCount) -> float:
    """Return the two-sided p-value of Fisher's exact test for the difference of two shares.

    It is the sum of the probabilities of all tables that are at most as probable as the observed one.

    R. A. Fisher, Statistical Methods for Research Workers, 5th ed. (1934), section 21.02.

    >>> round(compute_fisher_p(FailureCount(3, 4), FailureCount(1, 4)), 4)  # the lady tasting tea
    0.4857
    """
    failing, passing = inside.failing + outside.failing, inside.runs - inside.failing + outside.runs - outside.failing

    def log_ways(count: int) -> float:
        return _log_choose(failing, count) + _log_choose(passing, inside.runs - count)

    counts = range(max(0, inside.runs - passing), min(failing, inside.runs) + 1)
    observed, total = log_ways(inside.failing), _log_choose(failing + passing, inside.runs)
    return min(1.0, sum(math.exp(ways - total) for ways in map(log_ways, counts) if ways <= observed + _ROUNDING))


def _log_choose(n: int, k: int) -> float:
    return math.lgamma(n + 1) - math.lgamma(k + 1) - math.lgamma(n - k + 1)


class _Run(NamedTuple):
    """The part of a record that the analysis compares. Unlike the record, it has no path."""

    is_failure: bool
    conditions: dict[str, float | str]


def _make_strata(records: Iterable[Record]) -> list[tuple[GroupKey, list[_Run]]]:
    """Return the runs that have conditions, grouped by backend, world and the names of the conditions.

    Worlds differ in their share of failing runs and in the conditions that are drawn, so a world could look like a
    cause.
    """
    strata: dict[tuple[GroupKey, tuple[str, ...]], list[_Run]] = {}
    for record in records:
        if conditions := record.result.conditions:
            stratum = strata.setdefault((GroupKey.from_record(record), tuple(sorted(conditions))), [])
            stratum.append(_Run(record.is_failure, conditions))
    return [(key, runs) for (key, _), runs in sorted(strata.items(), key=lambda item: item[0])]


def _split_runs(group: GroupKey, runs: Sequence[_Run]) -> Iterator[Split]:
    """Yield all splits of comparable runs by their conditions, with the p-value of each."""
    failing = [run.conditions for run in runs if run.is_failure]
    if len(failing) in (0, len(runs)):
        return
    for name in sorted(runs[0].conditions):
        values, failing_values = [run.conditions[name] for run in runs], [each[name] for each in failing]
        for sign, value, inside in _list_sides(values, failing_values):
            outside = FailureCount(len(failing) - inside.failing, len(runs) - inside.runs)
            p = compute_fisher_p(inside, outside)
            if inside.failing * outside.runs >= outside.failing * inside.runs:
                yield Split(group, name, sign, value, inside, outside, p)
            else:
                yield Split(group, name, {"<": "≥", "=": "≠"}[sign], value, outside, inside, p)


def _list_sides(
    values: Sequence[float | str], failing: Sequence[float | str]
) -> Iterator[tuple[str, float | str, FailureCount]]:
    """Yield a sign, a value and the runs on this side, for each split of a condition.

    values: the values of all runs. If any value is a word, all are treated as words.
    failing: the values of the failing runs.
    """
    numbers = sorted(value for value in values if not isinstance(value, str))
    if len(numbers) == len(values):
        failing_numbers = sorted(value for value in failing if not isinstance(value, str))
        for threshold in _choose_thresholds(numbers):
            yield "<", threshold, FailureCount(bisect_left(failing_numbers, threshold), bisect_left(numbers, threshold))
        return
    counts, failing_counts = Counter(map(str, values)), Counter(map(str, failing))
    words = sorted(counts) if len(counts) > 1 else []
    if len(words) == 2:  # both words have the same split
        words = [max(words, key=lambda word: failing_counts[word] / counts[word])]
    for word in words:
        yield "=", word, FailureCount(failing_counts[word], counts[word])


def _choose_thresholds(numbers: Sequence[float]) -> list[float]:
    gaps = list(pairwise(sorted(set(numbers))))
    if len(gaps) >= PARTS:
        gaps = [gaps[len(gaps) * part // PARTS] for part in range(1, PARTS)]
    return [_find_short_number_between(*gap) for gap in gaps]


def _find_short_number_between(below: float, above: float) -> float:
    """Return the number with the fewest digits that is greater than ``below`` and not greater than ``above``."""
    middle = (below + above) / 2
    short = (float(f"{middle:.{digits}g}") for digits in range(1, 18))
    return next((number for number in short if below < number <= above), above)


def _correct(splits: Iterable[Split]) -> list[Split]:
    """Return the splits with p-values corrected by Holm's method, the least first."""
    ordered = sorted(splits, key=lambda split: split.p)
    corrected, least = [], 0.0
    for rank, split in enumerate(ordered):
        least = max(least, min(1.0, split.p * (len(ordered) - rank)))
        corrected.append(replace(split, p=least))
    return corrected


def _find_reason(strata: Sequence[tuple[GroupKey, Sequence[_Run]]], ranked: Sequence[Split]) -> str:
    runs, failing = sum(len(each) for _, each in strata), sum(run.is_failure for _, each in strata for run in each)
    counts = f"({pluralize(runs, 'run')}, {failing} failing)"
    if not failing:
        return ""
    if not ranked:
        return f"in each world on each backend, all runs ended alike or had the same conditions {counts}"
    best = ranked[0]
    return f"no split is significant {counts}; the best: {best.side} {best.group}, {best.shares} ({format_p(best.p)})"
