"""Permutation test: shuffle which runs failed, and measure how good the best split is by chance."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.sweep.statistics import subsample

SHUFFLES = 999
"""The number of shuffles. With the observed runs they are 1000, so a p of 5 % has a standard error of 0.7 %."""

_CELLS = 1_000_000
"""The most array cells that are counted at a time. All permutations of a big sweep would fill the memory."""

MAX_THRESHOLDS = 128
"""The most thresholds for a condition. All 599 thresholds of 600 runs take five times as long and find no more."""

Value = float | str

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


def shuffle_failing(runs: int, failing: Ints, random: np.random.RandomState) -> Ints:
    """Return the indices of failing runs, of shape (1 + `SHUFFLES`, k).

    runs: the number of runs.
    failing: the indices of the k runs that failed. They become the first row.
    random: the generator that draws the k indices of each other row.
    """
    rows = np.empty((1 + SHUFFLES, len(failing)), np.int64)
    rows[0] = failing
    for row in rows[1:]:
        row[:] = random.permutation(runs)[: len(failing)]
    return rows


def find_best_side(splits: Splits, rows: Ints) -> tuple[int, Floats]:
    """Find the side of a split that best separates the observed failures, by the p-value of Fisher's exact test.

    splits: the splits of one condition.
    rows: the indices of failing runs, as `shuffle_failing` returns them. The first row has the observed failures.

    Return the index of the side, and the natural logarithm of the least p-value in each row.

    >>> splits = Splits.of([0.1, 0.2, 0.3, 0.7, 0.8, 0.9])
    >>> failing = np.array([0, 1, 2])
    >>> rows = shuffle_failing(6, failing, np.random.RandomState(0))
    >>> side, log_p = find_best_side(splits, rows)
    >>> splits.build_split(side, failing)
    Split(sign='<', value=0.5, inside=Share(failing=3, runs=3), outside=Share(failing=0, runs=3))
    >>> float(np.mean(log_p <= log_p[0] + 1e-9))  # the fraction of permutations with a split at least as good
    0.114
    """
    log_p = list(_compute_log_p(splits, rows))
    return int(log_p[0][0].argmin()), np.concatenate([each.min(axis=1) for each in log_p])


def _compute_log_p(splits: Splits, rows: Ints) -> Iterator[Floats]:
    """Yield the logarithms of the p-values of Fisher's test for blocks of n rows, each of shape (n, sides)."""
    failing, sides = rows.shape[1], np.arange(len(splits.sides))
    table = compute_log_tails(len(splits.classes), failing, splits.sizes)
    step = max(1, _CELLS // (failing + len(sides)))
    for start in range(0, len(rows), step):
        yield table[sides, splits.count_inside(rows[start : start + step])]


class Share(NamedTuple):
    """A number of runs, and how many of them failed."""

    failing: int
    """The number of failing runs."""

    runs: int
    """The number of all runs."""

    def __str__(self) -> str:
        return f"{self.failing} of {self.runs}"


class Split(NamedTuple):
    """A split of runs into two parts by the value of one condition."""

    sign: str
    """``<``, ``≥`` or ``=``."""

    value: Value
    """The value that the condition is compared with."""

    inside: Share
    """The runs for which the comparison is true."""

    outside: Share
    """The other runs."""


class SplitSide(NamedTuple):
    """One side of a split: a range of classes of runs."""

    sign: str
    """``<``, ``≥`` or ``=``."""

    value: Value
    """The value that the condition is compared with."""

    first: int
    """The first class on this side."""

    end: int
    """The class after the last one on this side."""


@dataclass(frozen=True)
class Splits:
    """All splits of a condition that the test tries."""

    classes: Ints
    """The number of each run's class. Runs are in the same class if no split separates them."""

    sides: tuple[SplitSide, ...]
    """Both sides of each split."""

    @classmethod
    def of(cls, values: Sequence[Value]) -> Splits:
        """Return the splits of runs, given the condition's value in each run.

        Numbers are split by thresholds. If any value is a word, each word is split from all others.
        """
        numbers = [value for value in values if not isinstance(value, str)]
        return (
            _split_by_threshold(numbers)
            if len(numbers) == len(values)
            else _split_by_word([str(value) for value in values])
        )

    @property
    def sizes(self) -> Ints:
        """The number of all runs on each side."""
        sizes: Ints = self.count_inside(np.arange(len(self.classes))[None])[0]
        return sizes

    def count_inside(self, runs: Ints) -> Ints:
        """Count the runs on each side.

        runs: the indices of runs, of shape (n, k).

        Return the counts, of shape (n, sides).
        """
        rows, count = len(runs), 1 + int(self.classes.max())
        cells = count * np.arange(rows)[:, None] + self.classes[runs]
        per_class = np.bincount(cells.ravel(), minlength=rows * count).reshape(rows, count)
        below: Ints = np.pad(per_class.cumsum(axis=1), ((0, 0), (1, 0)))
        first, end = np.array([(side.first, side.end) for side in self.sides]).T
        inside: Ints = below[:, end] - below[:, first]
        return inside

    def build_split(self, side: int, failing: Ints) -> Split:
        """Return the split of a side, with its shares.

        side: the index of the side.
        failing: the indices of the runs that failed.
        """
        inside = Share(int(self.count_inside(failing[None])[0, side]), int(self.sizes[side]))
        outside = Share(len(failing) - inside.failing, len(self.classes) - inside.runs)
        return Split(*self.sides[side][:2], inside, outside)


def _split_by_threshold(numbers: Sequence[float]) -> Splits:
    gaps = subsample(list(pairwise(sorted(set(numbers)))), MAX_THRESHOLDS)
    thresholds = [_shortest_between(*gap) for gap in gaps]
    classes = np.searchsorted(thresholds, numbers, side="right")
    return Splits(classes, tuple(_make_sides(thresholds)))


def _make_sides(thresholds: Sequence[float]) -> Iterator[SplitSide]:
    for below, threshold in enumerate(thresholds):
        yield SplitSide("<", threshold, 0, below + 1)
        yield SplitSide("≥", threshold, below + 1, len(thresholds) + 1)


def _split_by_word(values: Sequence[str]) -> Splits:
    words, classes = np.unique(values, return_inverse=True)
    several = enumerate(words.tolist() if len(words) > 1 else ())
    return Splits(classes, tuple(SplitSide("=", word, at, at + 1) for at, word in several))


def _shortest_between(below: float, above: float) -> float:
    """Return the number with the fewest digits that is greater than ``below`` and not greater than ``above``."""
    middle = (below + above) / 2
    short = (float(f"{middle:.{digits}g}") for digits in range(1, 18))
    return next((number for number in short if below < number <= above), above)


def compute_log_tails(runs: int, failing: int, sizes: Ints) -> Floats:
    """Return the logarithms of the p-values of Fisher's exact test, one-sided, of shape (sizes, failing + 1).

    runs: the number of all runs.
    failing: the number of failing runs.
    sizes: the number of runs on each side of a split. The result has a row for each.

    Column k has the probability that at least k failing runs are on the side by chance. This is the upper tail of the
    hypergeometric distribution. A probability may be too small for a float, so the function returns logarithms.

    R. A. Fisher, Statistical Methods for Research Workers, 5th ed. (1934), section 21.02.

    >>> float(np.exp(compute_log_tails(8, 4, np.array([4]))[0, 4]).round(4))  # 1 of 70 draws
    0.0143
    """
    inside, size = np.arange(failing + 1), sizes[:, None]
    log_factorial = np.concatenate([[0.0], np.log(np.arange(1, runs + 1)).cumsum()])

    def log_choose(n: int, k: Ints) -> Floats:
        within = np.clip(k, 0, n)
        ways: Floats = log_factorial[n] - log_factorial[within] - log_factorial[n - within]
        return np.where(within == k, ways, -np.inf)

    log_p = log_choose(failing, inside) + log_choose(runs - failing, size - inside) - log_choose(runs, size)
    return np.logaddexp.accumulate(log_p[:, ::-1], axis=1)[:, ::-1]
