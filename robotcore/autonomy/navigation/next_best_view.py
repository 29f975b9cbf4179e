"""Exploration: what a camera has seen of the floor, and the viewpoint that shows most of the rest."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.autonomy.navigation.grid_search import (
    UNREACHED,
    Angles,
    Cell,
    Cells,
    Mask,
    Rays,
    Steps,
    backtrack,
    hidden,
    rays_from,
    wavefront,
)
from robotcore.autonomy.navigation.occupancy_grid import CLOSE_M, OccupancyGrid
from robotcore.autonomy.navigation.planner import MARGINS_M, Path, Traversability
from robotcore.geometry import Pose

VIEW_M = 1.8
"""How far a view counts: farther away a small ball may be missed."""

GUESS_M = 0.5
"""How much of the unknown a view may be hoped to pass."""

DOUBT = 0.25
"""The chance that a wall which was only heard from afar is a gap, to see through."""

MIN_TURN_M2 = 0.05
"""Less than this is not worth turning to."""

FINE_RAD = 0.016
"""Between rays that leave out no cell within VIEW_M."""

COARSE_RAYS = 36
COARSE_CELLS = 2
"""Rays all round, and from how many cells one is taken along them, that are enough to estimate an area by."""

_SQUARE = cv2.getStructuringElement(cv2.MORPH_RECT, (3, 3))

Areas = NDArray[np.float64]
Chances = NDArray[np.float64]


class Coverage:
    """What a camera has looked at on a map, so that it is not sought again; ``looked_at`` is a mask of the grid."""

    def __init__(self, grid: OccupancyGrid) -> None:
        self.looked_at = np.zeros_like(grid.free)
        self._grid = grid
        self._angles = np.linspace(0.0, math.tau, COARSE_RAYS, endpoint=False, dtype=np.float64)

    def add_view(self, eye: Pose, field_of_view: float) -> None:
        """Take in that a camera looked: what is known to be free before it, within VIEW_M, it has seen."""
        half = field_of_view / 2
        angles = eye.heading + np.linspace(-half, half, math.ceil(field_of_view / FINE_RAD))
        rays = self._rays(self._cell(eye.x, eye.y), angles, 1)
        self._note(rays, ~hidden(~rays.of(self._grid.free)))

    def add_look_round(self, x: float, y: float) -> None:
        """Take in that a camera looked all round: what it could not see from here is not to be seen from here."""
        angles = np.linspace(0.0, math.tau, math.ceil(math.tau / FINE_RAD))
        rays = self._rays(self._cell(x, y), angles, 1)
        self._note(rays, self._chances(rays, 1) > 0)

    def unseen_bearings(self, pose: Pose) -> Angles:
        """Return where to turn to see from here what was not looked at, in [-π, π)."""
        areas = self._areas(self._cell(pose.x, pose.y))[0]
        around = areas + np.roll(areas, 1) + np.roll(areas, -1)
        return np.asarray((self._angles[around >= MIN_TURN_M2] - pose.heading + math.pi) % math.tau - math.pi)

    def gains(self, cells: Cells) -> Areas:
        """Return for each of the cells, (n, 2), how much can be seen from it that was not looked at, in m²."""
        return np.asarray(self._areas(cells).sum(axis=1))

    def _areas(self, cells: Cells) -> Areas:
        """Return how much may be seen from cells along each coarse ray, in m², (n, rays)."""
        rays = self._rays(cells, self._angles, COARSE_CELLS)
        radii = COARSE_CELLS * np.arange(1, rays.rows.shape[2] + 1)
        areas = radii * (COARSE_CELLS * math.tau / COARSE_RAYS * self._grid.cell**2)
        return np.asarray((self._chances(rays, COARSE_CELLS) * areas).sum(axis=2))

    def _chances(self, rays: Rays, step: int) -> Chances:
        """Return the chance that a camera sees what it has not looked at, for each cell of rays: 1, DOUBT, or 0.

        What is unknown hides nothing for GUESS_M. Doubted are only walls nearer than CLOSE_M: those will be heard from
        near by a robot that goes there to look.
        """
        hides = self._hides(rays, self._grid.taken)
        hides_surely = self._hides(rays, self._grid.taken & ~self._grid.doubtful)
        is_near = np.arange(hides.shape[2]) < round(CLOSE_M / self._grid.cell / step)
        unknown = np.cumsum(~rays.of(self._grid.free), axis=2) * (step * self._grid.cell)
        is_new = (unknown <= GUESS_M) & ~rays.of(self.looked_at)
        chances = np.where(hidden(np.where(is_near, hides_surely, hides)), 0.0, DOUBT)
        return np.asarray(np.where(hidden(hides), chances, 1.0) * is_new)

    def _hides(self, rays: Rays, walls: Mask) -> Mask:
        """Return where walls hide what is behind: a cell thicker, so that no ray slips through between two cells."""
        thick = np.asarray(cv2.dilate(walls.astype(np.uint8), _SQUARE), np.bool_)
        return np.asarray(rays.of(thick) | ~rays.inside)

    def _note(self, rays: Rays, is_seen: Mask) -> None:
        self.looked_at[rays.rows[is_seen], rays.columns[is_seen]] = True

    def _rays(self, cells: Cells, angles: Angles, step: int) -> Rays:
        radii = np.arange(step, round(VIEW_M / self._grid.cell) + 1, step)
        return rays_from(cells, angles, radii, self._grid.count)

    def _cell(self, x: float, y: float) -> Cells:
        return np.array([self._grid.cell_of(x, y)])


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


class Viewpoint(NamedTuple):
    """A place to look round at, the way there, and how much must be to be seen from it to go on, in m²."""

    place: Cell
    way: Path
    least_gain: float

    def is_worth_going(self, coverage: Coverage) -> bool:
        """Return whether what the place promised is still to be seen."""
        return bool(coverage.gains(np.array([self.place]))[0] >= self.least_gain)


def best_viewpoint(ground: Traversability, coverage: Coverage, here: Cell) -> Viewpoint | None:
    """Return where most can be seen for the way, over what is known to be free; None where there is nothing."""
    masks = ground.open_cells(here)
    waves = [wavefront(here, mask) for mask in masks]
    cells = _candidates(waves[-1])
    gains = coverage.gains(cells)
    worths = np.stack([_worths(gains, wave[tuple(cells.T)], ground.grid.cell) for wave in waves])
    worths *= NARROW ** np.arange(len(MARGINS_M))[:, None]
    if not worths.any():
        return None
    margin, best = np.unravel_index(int(worths.argmax()), worths.shape)
    place = int(cells[best, 0]), int(cells[best, 1])
    way = Path(backtrack(waves[margin], place), masks[margin])
    return Viewpoint(place, way, max(MIN_GAIN_M2, KEPT_GAIN * float(gains[best])))


def _candidates(steps: Steps) -> Cells:
    """Return cells, (n, 2), that the wave with the narrowest margin has reached: it goes wherever the others go."""
    return np.argwhere(steps[::EVERY, ::EVERY] != UNREACHED) * EVERY


def _worths(gains: Areas, steps: Steps, cell: float) -> Areas:
    """Return what views are worth, in m² for each metre that they cost; 0 where they are none."""
    ways = steps * cell
    is_view = (gains >= MIN_GAIN_M2) & (ways >= ELSEWHERE_M) & (steps != UNREACHED)
    return np.where(is_view, gains / (LOOK_ROUND_M + ways), 0.0)
