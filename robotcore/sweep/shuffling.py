"""How surely chance too would part failing runs from passing ones: who failed, shuffled."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from robotcore.sweep.fisher import Floats, Ints, log_tails
from robotcore.sweep.splits import Splits

SHUFFLES = 999
"""With the runs as they failed 1000 rows, which tell a chance of 5 % with a standard error of 0.7 %."""

_CELLS = 1_000_000
"""About so many numbers are counted at a time; all shuffles at once of a big sweep would fill the memory."""


def shuffled(runs: int, failing: Ints, random: np.random.RandomState) -> Ints:
    """Return which runs fail: in the first row those that did, in each of `SHUFFLES` more as many, drawn by chance."""
    rows = np.empty((1 + SHUFFLES, len(failing)), np.int64)
    rows[0] = failing
    for row in rows[1:]:
        row[:] = random.permutation(runs)[: len(failing)]
    return rows


def best_side(splits: Splits, rows: Ints) -> tuple[int, Floats]:
    """Return the side that chance explains least in the first row, and the logarithm of that least chance in each."""
    chances = list(_log_chances(splits, rows))
    return int(chances[0][0].argmin()), np.concatenate([each.min(axis=1) for each in chances])


def _log_chances(splits: Splits, rows: Ints) -> Iterator[Floats]:
    """Yield Fisher's chance of each side, in logarithms, for some more rows: of shape (n, sides)."""
    failing, sides = rows.shape[1], np.arange(len(splits.sides))
    table = log_tails(len(splits.classes), failing, splits.sizes)
    step = max(1, _CELLS // (failing + len(sides)))
    for start in range(0, len(rows), step):
        yield table[sides, splits.inside(rows[start : start + step])]
