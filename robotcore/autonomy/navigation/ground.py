"""Where on a map a robot fits."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

import numpy as np

from robotcore.autonomy.navigation.grid import Metres, OccupancyGrid
from robotcore.autonomy.navigation.paths import UNREACHED, Cell, Mask, path_back, steps_from

MARGINS_M = (0.08, 0.05, 0.02)
"""How much more than its own reach the robot keeps from things; the next where the one before leaves no way."""

BARRED_M = 0.2
"""The radius of what is not tried again, round a place where no way opened."""

BESIDE = 2
"""Cells round its own that the robot may step on, however narrow it is there, to get out."""


class Trust(Enum):
    """What a way may lead over."""

    KNOWN = "what is known to be free"
    UNKNOWN = "the unknown too"
    DOUBTFUL = "the unknown, and what was only heard from afar"


class Way(NamedTuple):
    """Cells one after the other, and the cells over which the robot may cut it short."""

    path: list[Cell]
    open_cells: Mask


NO_WAY = Way([], np.zeros((0, 0), np.bool_))


class Ground:
    """Where a robot fits that needs ``reach`` metres round its axle to turn on the spot."""

    def __init__(self, grid: OccupancyGrid, reach: float) -> None:
        self.grid = grid
        self.reach = reach
        self._barred = np.zeros_like(grid.taken)

    def bar(self, cell: Cell) -> None:
        """Lead no way that is not known through what lies about a cell."""
        self._barred |= self.grid.disc(*self.grid.point_of(*cell), BARRED_M)

    def open_cells(self, here: Cell, trust: Trust = Trust.KNOWN) -> list[Mask]:
        """Return for each of MARGINS_M on which cells a robot that stands ``here`` may go."""
        clearance = self._clearance(trust)
        masks = [np.asarray(clearance > self.reach + margin) for margin in MARGINS_M]
        beside = tuple(slice(max(at - BESIDE, 0), at + BESIDE + 1) for at in here)
        for mask in masks:
            mask[beside] |= ~self.grid.taken[beside]
        return masks

    def way_to(self, here: Cell, goal: Cell) -> Way:
        """Return a way over what is known, with the widest margin that there is; NO_WAY where there is none."""
        goals = np.zeros_like(self._barred)
        goals[goal] = True
        for mask in self.open_cells(here):
            steps = steps_from(here, mask, goals)
            if steps[goal] != UNREACHED:
                return Way(path_back(steps, goal), mask)
        return NO_WAY

    def _clearance(self, trust: Trust) -> Metres:
        if trust is Trust.KNOWN:
            return self.grid.clearance()
        overlook = self.grid.doubtful if trust is Trust.DOUBTFUL else None
        clearance = self.grid.clearance(with_unknown=False, overlook=overlook)
        clearance[self._barred] = 0.0
        return clearance
