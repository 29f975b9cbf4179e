"""What failing runs have in common: of each condition the one split that chance explains least."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import NamedTuple

from robotcore.sweep.place import Place
from robotcore.sweep.record import Record
from robotcore.sweep.thinning import thinned

SIGNIFICANCE = 0.05
MAX_THRESHOLDS = 64
"""More would cost power: each one tried makes the test of all stricter."""

Case = tuple[float | str, bool]
"""A condition's value in a run, and whether the run failed."""


class Share(NamedTuple):
    """How many of some runs failed."""

    failing: int
    runs: int

    def __str__(self) -> str:
        return f"{self.failing} of {self.runs}"


class Split(NamedTuple):
    """The runs where ``value`` holds, of one condition, and the runs elsewhere; ``sign`` is ``<``, ``≥`` or ``=``."""

    sign: str
    value: float | str
    inside: Share
    outside: Share

    @property
    def p(self) -> float:
        """The chance that so many fail inside if the condition does not matter."""
        return fisher(self.inside, self.outside)


@dataclass(frozen=True)
class Finding:
    """Runs of a place fail more often on one side of a split; ``p`` is corrected for all the splits that were tried."""

    place: Place
    condition: str
    split: Split
    p: float

    @property
    def where(self) -> str:
        """The side on which more runs fail, such as ``light_brightness < 0.34``."""
        return f"{self.condition} {self.split.sign} {str(self.split.value).removesuffix('.0')}"

    def __str__(self) -> str:
        return f"fails more {self.place} where {self.where}: {self.split.inside}, elsewhere {self.split.outside}"


def explain(records: Iterable[Record]) -> list[Finding]:
    """Return the conditions that explain failures, the surest first.

    Each backend is looked at in each world by itself: the same seed draws the same conditions for every backend, so
    that its runs are no independent cases, and worlds differ in how often runs fail as they do in what is drawn. Runs
    that do not tell a condition are left out of it. The chance is multiplied by the number of splits tried anywhere
    (Bonferroni), and told where it stays within 5 %.
    """
    splits = {key: list(_splits(cases)) for key, cases in _cases(records).items()}
    tried = sum(map(len, splits.values()))
    best = ((key, min(some, key=lambda split: split.p)) for key, some in splits.items() if some)
    findings = (Finding(*key, split, min(1.0, split.p * tried)) for key, split in best)
    return sorted((each for each in findings if each.p <= SIGNIFICANCE), key=lambda each: each.p)


def unexplained(records: Iterable[Record]) -> list[str]:
    """Return what to say where `explain` finds nothing: a line, or none where no run that tells conditions failed."""
    failed = [record.is_failure for record in records if record.result.conditions]
    if not any(failed):
        return []
    return [f"nothing that chance does not explain as well ({len(failed)} runs, {sum(failed)} failing)"]


def fisher(inside: Share, outside: Share) -> float:
    """Return the chance that of all who fail as many or more are inside; 1 where inside does not fail more often.

    Fisher's exact test, one-sided: R. A. Fisher, Statistical Methods for Research Workers, 5th ed. (1934), section
    21.02. It is the upper tail of the hypergeometric distribution, each term made from the one before it.
    """
    if inside.failing * outside.runs <= outside.failing * inside.runs:
        return 1.0
    count, drawn = inside.failing, inside.runs
    failing, runs = inside.failing + outside.failing, inside.runs + outside.runs
    passing = runs - failing
    term = math.exp(_log_choose(failing, count) + _log_choose(passing, drawn - count) - _log_choose(runs, drawn))
    tail = 0.0
    while term > tail * 1e-16:
        tail += term
        term *= (failing - count) * (drawn - count) / ((count + 1) * (passing - drawn + count + 1))
        count += 1
    return min(1.0, tail)


def _log_choose(n: int, k: int) -> float:
    return math.lgamma(n + 1) - math.lgamma(k + 1) - math.lgamma(n - k + 1)


def _cases(records: Iterable[Record]) -> dict[tuple[Place, str], list[Case]]:
    """Return, by the place and the condition's name, its value in each run that tells it."""
    cases: dict[tuple[Place, str], list[Case]] = {}
    for record in records:
        for name, value in record.result.conditions.items():
            cases.setdefault((Place.of(record), name), []).append((value, record.is_failure))
    return cases


def _splits(cases: Sequence[Case]) -> Iterator[Split]:
    """Yield every split that is tried: below and above each threshold, or each word against the others."""
    numbers = [(value, failed) for value, failed in cases if not isinstance(value, str)]
    if len(numbers) == len(cases):
        yield from _by_threshold(sorted(numbers))
    else:
        yield from _by_word([(str(value), failed) for value, failed in cases])


def _by_threshold(cases: Sequence[tuple[float, bool]]) -> Iterator[Split]:
    failing = [0, *accumulate(failed for _, failed in cases)]
    cuts = [at for at in range(1, len(cases)) if cases[at - 1][0] < cases[at][0]]
    for at in thinned(cuts, MAX_THRESHOLDS):
        value = _between(cases[at - 1][0], cases[at][0])
        below = Share(failing[at], at)
        above = Share(failing[-1] - failing[at], len(cases) - at)
        yield Split("<", value, below, above)
        yield Split("≥", value, above, below)


def _by_word(cases: Sequence[tuple[str, bool]]) -> Iterator[Split]:
    words = sorted({word for word, _ in cases})
    for word in words if len(words) > 1 else ():
        inside = [failed for each, failed in cases if each == word]
        outside = [failed for each, failed in cases if each != word]
        yield Split("=", word, Share(sum(inside), len(inside)), Share(sum(outside), len(outside)))


def _between(below: float, above: float) -> float:
    """Return the shortest number that is greater than ``below`` and not greater than ``above``."""
    middle = (below + above) / 2
    short = (float(f"{middle:.{digits}g}") for digits in range(1, 18))
    return next((number for number in short if below < number <= above), above)
