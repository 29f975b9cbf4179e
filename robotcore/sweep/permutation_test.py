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
"""With the runs as they failed 1000 rows, which tell a chance of 5 % with a standard error of 0.7 %."""

_CELLS = 1_000_000
"""About so many numbers are counted at a time; all shuffles at once of a big sweep would fill the memory."""

MAX_THRESHOLDS = 128
"""Neighbours part a big sweep almost alike: of 600 runs all 599 find no more causes, and take five times as long."""

Value = float | str

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]


def shuffle_failing(runs: int, failing: Ints, random: np.random.RandomState) -> Ints:
    """Return which runs fail: in the first row those that did, in each of `SHUFFLES` more as many, drawn by chance."""
    rows = np.empty((1 + SHUFFLES, len(failing)), np.int64)
    rows[0] = failing
    for row in rows[1:]:
        row[:] = random.permutation(runs)[: len(failing)]
    return rows


def find_best_side(splits: Splits, rows: Ints) -> tuple[int, Floats]:
    """Return the side that chance explains least in the first row, and the logarithm of that least chance in each."""
    chances = list(_compute_log_chances(splits, rows))
    return int(chances[0][0].argmin()), np.concatenate([each.min(axis=1) for each in chances])


def _compute_log_chances(splits: Splits, rows: Ints) -> Iterator[Floats]:
    """Yield Fisher's chance of each side, in logarithms, for some more rows: of shape (n, sides)."""
    failing, sides = rows.shape[1], np.arange(len(splits.sides))
    table = compute_log_tails(len(splits.classes), failing, splits.sizes)
    step = max(1, _CELLS // (failing + len(sides)))
    for start in range(0, len(rows), step):
        yield table[sides, splits.inside(rows[start : start + step])]


class Share(NamedTuple):
    """How many of some runs failed."""

    failing: int
    runs: int

    def __str__(self) -> str:
        return f"{self.failing} of {self.runs}"


class Split(NamedTuple):
    """The runs where ``value`` holds, of one condition, and the runs elsewhere; ``sign`` is ``<``, ``≥`` or ``=``."""

    sign: str
    value: Value
    inside: Share
    outside: Share


class SplitSide(NamedTuple):
    """One side of a split that is tried: the classes from ``first`` up to, but without, ``end``."""

    sign: str
    value: Value
    first: int
    end: int


@dataclass(frozen=True)
class Splits:
    """All the splits of a condition that are tried.

    Runs that no threshold parts are a class; ``classes`` has the class of each run.
    """

    classes: Ints
    sides: tuple[SplitSide, ...]

    @classmethod
    def of(cls, values: Sequence[Value]) -> Splits:
        """Return the splits of runs by a condition's value in each: by thresholds, or each word against the others."""
        numbers = [value for value in values if not isinstance(value, str)]
        return (
            _split_by_threshold(numbers)
            if len(numbers) == len(values)
            else _split_by_word([str(value) for value in values])
        )

    @property
    def sizes(self) -> Ints:
        """How many of all runs are on each side."""
        sizes: Ints = self.inside(np.arange(len(self.classes))[None])[0]
        return sizes

    def inside(self, runs: Ints) -> Ints:
        """Return how many of some runs are on each side: ``runs``, of shape (n, k), give shape (n, sides)."""
        rows, count = len(runs), 1 + int(self.classes.max())
        cells = count * np.arange(rows)[:, None] + self.classes[runs]
        per_class = np.bincount(cells.ravel(), minlength=rows * count).reshape(rows, count)
        below: Ints = np.pad(per_class.cumsum(axis=1), ((0, 0), (1, 0)))
        first, end = np.array([(side.first, side.end) for side in self.sides]).T
        inside: Ints = below[:, end] - below[:, first]
        return inside

    def split(self, side: int, failing: Ints) -> Split:
        """Return a split by the number of its side, with its shares; ``failing`` are the runs that failed."""
        inside = Share(int(self.inside(failing[None])[0, side]), int(self.sizes[side]))
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
    """Return the shortest number that is greater than ``below`` and not greater than ``above``."""
    middle = (below + above) / 2
    short = (float(f"{middle:.{digits}g}") for digits in range(1, 18))
    return next((number for number in short if below < number <= above), above)


def compute_log_tails(runs: int, failing: int, sizes: Ints) -> Floats:
    """Return a table: the logarithm of the chance that ``column`` or more of all who fail are inside a split.

    Of shape (sizes, failing + 1), a row for each number of runs inside. Fisher's exact test, one-sided: R. A. Fisher,
    Statistical Methods for Research Workers, 5th ed. (1934), section 21.02. It is the upper tail of the hypergeometric
    distribution; in logarithms, since of a big sweep it may be less than any float.
    """
    inside, size = np.arange(failing + 1), sizes[:, None]
    log_factorial = np.concatenate([[0.0], np.log(np.arange(1, runs + 1)).cumsum()])

    def log_choose(n: int, k: Ints) -> Floats:
        within = np.clip(k, 0, n)
        ways: Floats = log_factorial[n] - log_factorial[within] - log_factorial[n - within]
        return np.where(within == k, ways, -np.inf)

    log_chance = log_choose(failing, inside) + log_choose(runs - failing, size - inside) - log_choose(runs, size)
    return np.logaddexp.accumulate(log_chance[:, ::-1], axis=1)[:, ::-1]
