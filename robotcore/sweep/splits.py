"""The ways in which one condition parts the runs of a place in two."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from robotcore.sweep.fisher import Ints
from robotcore.sweep.thinning import thinned

MAX_THRESHOLDS = 128
"""Neighbours part a big sweep almost alike: of 600 runs all 599 find no more causes, and take five times as long."""

Value = float | str


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


class Side(NamedTuple):
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
    sides: tuple[Side, ...]

    @classmethod
    def of(cls, values: Sequence[Value]) -> Splits:
        """Return the splits of runs by a condition's value in each: by thresholds, or each word against the others."""
        numbers = [value for value in values if not isinstance(value, str)]
        return _by_threshold(numbers) if len(numbers) == len(values) else _by_word([str(value) for value in values])

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


def _by_threshold(numbers: Sequence[float]) -> Splits:
    gaps = thinned(list(pairwise(sorted(set(numbers)))), MAX_THRESHOLDS)
    thresholds = [_between(*gap) for gap in gaps]
    classes = np.searchsorted(thresholds, numbers, side="right")
    return Splits(classes, tuple(_sides(thresholds)))


def _sides(thresholds: Sequence[float]) -> Iterator[Side]:
    for below, threshold in enumerate(thresholds):
        yield Side("<", threshold, 0, below + 1)
        yield Side("≥", threshold, below + 1, len(thresholds) + 1)


def _by_word(values: Sequence[str]) -> Splits:
    words, classes = np.unique(values, return_inverse=True)
    several = enumerate(words.tolist() if len(words) > 1 else ())
    return Splits(classes, tuple(Side("=", word, at, at + 1) for at, word in several))


def _between(below: float, above: float) -> float:
    """Return the shortest number that is greater than ``below`` and not greater than ``above``."""
    middle = (below + above) / 2
    short = (float(f"{middle:.{digits}g}") for digits in range(1, 18))
    return next((number for number in short if below < number <= above), above)
