"""Where to go to see most of what was not looked at."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robotcore.autonomy.navigation.coverage import Areas, Coverage
from robotcore.autonomy.navigation.ground import MARGINS_M, Ground, Way
from robotcore.autonomy.navigation.paths import UNREACHED, Cell, Steps, path_back, steps_from
from robotcore.autonomy.navigation.rays import Cells

MIN_GAIN_M2 = 0.1
"""A view of less is not worth driving to."""

KEPT_GAIN = 0.3
"""A view is worth going on to while at least this part of what it promised is still to be seen."""

ELSEWHERE_M = 0.3
"""A place nearer than this shows little that is not to be seen from here."""

LOOK_ROUND_M = 1.2
"""The way that could be driven in the time that looking round takes."""

NARROW = 0.85
"""What a view is worth for each margin that is too wide for the way to it, against one that has the widest."""

EVERY = 4
"""Of the rows and of the columns, which are considered: views from neighbouring cells are much the same."""


class View(NamedTuple):
    """A place to look round at, the way there, and how much must be to be seen from it to go on, in m²."""

    place: Cell
    way: Way
    least_gain: float

    def is_worth_going(self, coverage: Coverage) -> bool:
        """Return whether what the place promised is still to be seen."""
        return bool(coverage.gains(np.array([self.place]))[0] >= self.least_gain)


def best_view(ground: Ground, coverage: Coverage, here: Cell) -> View | None:
    """Return where most can be seen for the way, over what is known to be free; None where there is nothing."""
    masks = ground.open_cells(here)
    waves = [steps_from(here, mask) for mask in masks]
    cells = _candidates(waves[-1])
    gains = coverage.gains(cells)
    worths = np.stack([_worths(gains, wave[tuple(cells.T)], ground.grid.cell) for wave in waves])
    worths *= NARROW ** np.arange(len(MARGINS_M))[:, None]
    if not worths.any():
        return None
    margin, best = np.unravel_index(int(worths.argmax()), worths.shape)
    place = int(cells[best, 0]), int(cells[best, 1])
    way = Way(path_back(waves[margin], place), masks[margin])
    return View(place, way, max(MIN_GAIN_M2, KEPT_GAIN * float(gains[best])))


def _candidates(steps: Steps) -> Cells:
    """Return cells, (n, 2), that the wave with the narrowest margin has reached: it goes wherever the others go."""
    return np.argwhere(steps[::EVERY, ::EVERY] != UNREACHED) * EVERY


def _worths(gains: Areas, steps: Steps, cell: float) -> Areas:
    """Return what views are worth, in m² for each metre that they cost; 0 where they are none."""
    ways = steps * cell
    is_view = (gains >= MIN_GAIN_M2) & (ways >= ELSEWHERE_M) & (steps != UNREACHED)
    return np.where(is_view, gains / (LOOK_ROUND_M + ways), 0.0)
