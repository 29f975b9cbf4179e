"""Permutation test: split runs by a condition, and compare the best split with the best splits of shuffled failures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.sweep.statistics import subsample

SHUFFLES = 999
"""The number of shuffles. With 1000 permutations (the observed one included), p = 5 % has a standard error of 0.7 %."""

_CELLS = 1_000_000
"""The maximum size of an array of permutations, in cells. All permutations of a big sweep would fill the memory."""

MAX_THRESHOLDS = 128
"""The maximum number of thresholds for a condition. All 599 thresholds of 600 runs take five times as long, and the
results are no better."""

Value = float | str

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


def shuffle_failing(runs: int, failing: Ints, random: np.random.RandomState) -> Ints:
    """Return the indices of the failing runs in each permutation, of shape (1 + `SHUFFLES`, k).

    runs: the number of all runs.
    failing: the indices of the k runs that failed. They become the first row.
    random: the random generator that draws the k indices of each other row.
    """
    rows = np.empty((1 + SHUFFLES, len(failing)), np.int64)
    rows[0] = failing
    for row in rows[1:]:
        row[:] = random.permutation(runs)[: len(failing)]
    return rows


def find_best_side(splits: Splits, rows: Ints) -> tuple[int, Floats]:
    """Return the index of the side with the least p-value of the observed failures, by Fisher's exact test.

    Also return the natural logarithm of the least p-value of any side in each permutation.

    splits: the splits of one condition.
    rows: the indices of the failing runs in each permutation, as `shuffle_failing` returns them.

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
    """Yield the logarithms of the p-values of Fisher's exact test, of shape (n, sides), for n rows at a time."""
    failing, sides = rows.shape[1], np.arange(len(splits.sides))
    table = compute_log_tails(len(splits.bins), failing, splits.sizes)
    step = max(1, _CELLS // (failing + len(sides)))
    for start in range(0, len(rows), step):
        yield table[sides, splits.count_inside(rows[start : start + step])]


class Share(NamedTuple):
    """The number of runs on one side of a split, and how many of them failed."""

    failing: int
    """The number of failing runs."""

    runs: int
    """The number of all runs."""

    def __str__(self) -> str:
        return f"{self.failing} of {self.runs}"


class Split(NamedTuple):
    """A split of runs into two parts: a comparison of a condition with a value, and the runs for which it holds."""

    sign: str
    """The comparison: ``<``, ``≥`` or ``=``."""

    value: Value
    """The value that the condition is compared with: a threshold or a word."""

    inside: Share
    """The runs for which the comparison is true."""

    outside: Share
    """The runs for which the comparison is false."""

    @property
    def shares(self) -> str:
        """How many runs fail if the comparison is true, and how many else, such as ``7 of 12, else 3 of 188``."""
        return f"{self.inside}, else {self.outside}"

    def format_comparison(self, condition: str) -> str:
        """Return the comparison of a condition as text, such as ``light_brightness < 0.34``."""
        return f"{condition} {self.sign} {str(self.value).removesuffix('.0')}"


class SplitSide(NamedTuple):
    """One side of a split: a comparison of the condition with a value, and the bins for which it is true."""

    sign: str
    """The comparison: ``<``, ``≥`` or ``=``."""

    value: Value
    """The value that the condition is compared with: a threshold or a word."""

    first: int
    """The index of the first bin on this side."""

    end: int
    """The index after the last bin on this side."""


@dataclass(frozen=True)
class Splits:
    """The splits of runs by one condition. The thresholds or words of the splits sort the runs into bins."""

    bins: Ints
    """The index of each run's bin. Two runs are in the same bin if no split separates them."""

    sides: tuple[SplitSide, ...]
    """Both sides of each threshold, or one side for each word."""

    @classmethod
    def of(cls, values: Sequence[Value]) -> Splits:
        """Return the splits of runs by a condition.

        values: the condition's value in each run. Numbers are split at thresholds. If any value is a word, all values
            are treated as words, and each word is split from all others.
        """
        numbers = [value for value in values if not isinstance(value, str)]
        return (
            _split_by_threshold(numbers)
            if len(numbers) == len(values)
            else _split_by_word([str(value) for value in values])
        )

    @property
    def sizes(self) -> Ints:
        """The number of runs on each side."""
        sizes: Ints = self.count_inside(np.arange(len(self.bins))[None])[0]
        return sizes

    def count_inside(self, runs: Ints) -> Ints:
        """Return how many of the given runs are on each side, of shape (n, sides).

        runs: n rows of k indices of runs, of shape (n, k).
        """
        rows, count = len(runs), 1 + int(self.bins.max())
        cells = count * np.arange(rows)[:, None] + self.bins[runs]
        per_bin = np.bincount(cells.ravel(), minlength=rows * count).reshape(rows, count)
        below: Ints = np.pad(per_bin.cumsum(axis=1), ((0, 0), (1, 0)))
        first, end = np.array([(side.first, side.end) for side in self.sides]).T
        inside: Ints = below[:, end] - below[:, first]
        return inside

    def build_split(self, side: int, failing: Ints) -> Split:
        """Return the split of a side, with the numbers of failing runs in both parts.

        side: the index of the side in `sides`.
        failing: the indices of the runs that failed.
        """
        inside = Share(int(self.count_inside(failing[None])[0, side]), int(self.sizes[side]))
        outside = Share(len(failing) - inside.failing, len(self.bins) - inside.runs)
        return Split(*self.sides[side][:2], inside, outside)


def _split_by_threshold(numbers: Sequence[float]) -> Splits:
    gaps = subsample(list(pairwise(sorted(set(numbers)))), MAX_THRESHOLDS)
    thresholds = [_find_short_number_between(*gap) for gap in gaps]
    bins = np.searchsorted(thresholds, numbers, side="right")
    return Splits(bins, tuple(_make_sides(thresholds)))


def _make_sides(thresholds: Sequence[float]) -> Iterator[SplitSide]:
    for below, threshold in enumerate(thresholds):
        yield SplitSide("<", threshold, 0, below + 1)
        yield SplitSide("≥", threshold, below + 1, len(thresholds) + 1)


def _split_by_word(values: Sequence[str]) -> Splits:
    words, bins = np.unique(values, return_inverse=True)
    several = enumerate(words.tolist() if len(words) > 1 else ())
    return Splits(bins, tuple(SplitSide("=", word, at, at + 1) for at, word in several))


def _find_short_number_between(below: float, above: float) -> float:
    """Return the number with the fewest digits that is greater than ``below`` and not greater than ``above``."""
    middle = (below + above) / 2
    short = (float(f"{middle:.{digits}g}") for digits in range(1, 18))
    return next((number for number in short if below < number <= above), above)


def compute_log_tails(runs: int, failing: int, sizes: Ints) -> Floats:
    """Return the logarithms of the p-values of Fisher's one-sided exact test, a row for each side of a split.

    runs: the number of all runs.
    failing: the number of failing runs.
    sizes: the number of runs on each side.

    Column k, from 0 to ``failing``, has the probability that at least k failing runs are on the side by chance. This
    is the upper tail of the hypergeometric distribution. A probability may be too small for a float, so the function
    returns logarithms.

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
