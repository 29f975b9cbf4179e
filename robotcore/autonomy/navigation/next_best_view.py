"""Exploration: records the cells that a camera has seen, and chooses the cell from which it sees most new ones."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.autonomy.navigation.grid_paths import (
    UNREACHED,
    Angles,
    Cell,
    Cells,
    Mask,
    Rays,
    Steps,
    backtrack,
    mask_hidden,
    rays_from,
    wavefront,
)
from robotcore.autonomy.navigation.occupancy_grid import CLOSE_M, OccupancyGrid
from robotcore.autonomy.navigation.planner import MARGINS_M, Path, Traversability
from robotcore.geometry import Pose

VIEW_M = 1.8
"""Cells farther from the camera do not count as seen, because it may miss a small ball there."""

GUESS_M = 0.5
"""The camera is assumed to see through unknown cells for this distance."""

DOUBT = 0.25
"""The probability that an uncertain occupied cell is a gap, through which the camera sees."""

MIN_TURN_M2 = 0.05
"""The least unseen area, in m², that is visible at a bearing to which the robot turns."""

FINE_RAD = 0.016
"""The angle between fine rays. It is so small that the rays pass through every cell within `VIEW_M`."""

COARSE_RAYS = 36
"""The number of coarse rays over a full turn, for estimates of an area."""

COARSE_CELLS = 2
"""The distance between successive points of a coarse ray, in cells."""

_SQUARE = cv2.getStructuringElement(cv2.MORPH_RECT, (3, 3))

Areas = NDArray[np.float64]
Chances = NDArray[np.float64]


class Coverage:
    """The cells of a map that the camera has seen."""

    def __init__(self, grid: OccupancyGrid) -> None:
        self.seen = np.zeros_like(grid.free)
        """Whether the camera has seen a cell, as a mask of the grid."""
        self._grid = grid
        self._angles = np.linspace(0.0, math.tau, COARSE_RAYS, endpoint=False, dtype=np.float64)

    def add_view(self, eye: Pose, field_of_view: float) -> None:
        """Mark the free cells in a camera's field of view as seen.

        Cells that are farther than `VIEW_M`, or behind a cell that is not free, are not marked.

        eye: the camera's pose.
        field_of_view: the camera's horizontal field of view in radians.
        """
        half = field_of_view / 2
        angles = eye.heading + np.linspace(-half, half, math.ceil(field_of_view / FINE_RAD))
        rays = self._rays(self._cell(eye.x, eye.y), angles, 1)
        self._mark_seen(rays, ~mask_hidden(~rays.of(self._grid.free)))

    def add_full_turn(self, x: float, y: float) -> None:
        """Mark all cells as seen that a camera may see in a full turn at a point. Call it after such a turn."""
        angles = np.linspace(0.0, math.tau, math.ceil(math.tau / FINE_RAD))
        rays = self._rays(self._cell(x, y), angles, 1)
        self._mark_seen(rays, self._chances(rays, 1) > 0)

    def unseen_bearings(self, pose: Pose) -> Angles:
        """Return the bearings from a pose at which at least `MIN_TURN_M2` of unseen area is visible, in [-π, π)."""
        areas = self._areas(self._cell(pose.x, pose.y))[0]
        around = areas + np.roll(areas, 1) + np.roll(areas, -1)
        return np.asarray((self._angles[around >= MIN_TURN_M2] - pose.heading + math.pi) % math.tau - math.pi)

    def gains(self, cells: Cells) -> Areas:
        """Return for each cell the unseen area that is visible from it, in m², (n,).

        cells: rows and columns, (n, 2).
        """
        return np.asarray(self._areas(cells).sum(axis=1))

    def _areas(self, cells: Cells) -> Areas:
        """Return the unseen area along each coarse ray from each cell, in m², (n, rays)."""
        rays = self._rays(cells, self._angles, COARSE_CELLS)
        radii = COARSE_CELLS * np.arange(1, rays.rows.shape[2] + 1)
        areas = radii * (COARSE_CELLS * math.tau / COARSE_RAYS * self._grid.cell**2)
        return np.asarray((self._chances(rays, COARSE_CELLS) * areas).sum(axis=2))

    def _chances(self, rays: Rays, step: int) -> Chances:
        """Return for each cell along rays the probability that the camera will see it for the first time.

        The probability is 1, `DOUBT` or 0. The camera is assumed to see through unknown cells for `GUESS_M`. It sees
        through an uncertain cell with the probability `DOUBT` if the cell is nearer than `CLOSE_M` to the ray's start.
        """
        hides = self._hides(rays, self._grid.taken)
        hides_surely = self._hides(rays, self._grid.taken & ~self._grid.uncertain)
        is_near = np.arange(hides.shape[2]) < round(CLOSE_M / self._grid.cell / step)
        unknown = np.cumsum(~rays.of(self._grid.free), axis=2) * (step * self._grid.cell)
        is_new = (unknown <= GUESS_M) & ~rays.of(self.seen)
        chances = np.where(mask_hidden(np.where(is_near, hides_surely, hides)), 0.0, DOUBT)
        return np.asarray(np.where(mask_hidden(hides), chances, 1.0) * is_new)

    def _hides(self, rays: Rays, walls: Mask) -> Mask:
        """Return for each cell along rays whether it is opaque.

        Occupied cells are widened by one cell, so that no ray passes between two cells that touch at a corner.
        """
        thick = np.asarray(cv2.dilate(walls.astype(np.uint8), _SQUARE), np.bool_)
        return np.asarray(rays.of(thick) | ~rays.inside)

    def _mark_seen(self, rays: Rays, is_seen: Mask) -> None:
        self.seen[rays.rows[is_seen], rays.columns[is_seen]] = True

    def _rays(self, cells: Cells, angles: Angles, step: int) -> Rays:
        radii = np.arange(step, round(VIEW_M / self._grid.cell) + 1, step)
        return rays_from(cells, angles, radii, self._grid.count)

    def _cell(self, x: float, y: float) -> Cells:
        return np.array([self._grid.cell_of(x, y)])


MIN_GAIN_M2 = 0.1
"""The least unseen area that is visible from a viewpoint, in m²."""

KEPT_GAIN = 0.3
"""On the way to a viewpoint, the robot gives it up if less than this fraction of its unseen area is left."""

ELSEWHERE_M = 0.3
"""The least distance from the robot to a viewpoint. From nearer cells the camera sees the same as from here."""

LOOK_ROUND_M = 1.2
"""The cost of the full turn at a viewpoint, as the distance that the robot could drive in the same time."""

NARROW = 0.85
"""A viewpoint's worth is multiplied by this for each of `MARGINS_M` that is too wide for the path to it."""

EVERY = 4
"""Only every fourth row and column can have a viewpoint, because views from neighbouring cells are similar."""


class Viewpoint(NamedTuple):
    """A cell to which the robot drives to look around with its camera."""

    place: Cell
    path: Path
    """The path to the cell."""
    least_gain: float
    """The least unseen area, in m², for which the robot continues to the cell."""

    def is_worth_going(self, coverage: Coverage) -> bool:
        """Return whether at least `least_gain` of unseen area is still visible from the cell."""
        return bool(coverage.gains(np.array([self.place]))[0] >= self.least_gain)


def best_viewpoint(ground: Traversability, coverage: Coverage, here: Cell) -> Viewpoint | None:
    """Return the next best view: the viewpoint with the largest unseen area for each metre of its cost.

    Return None if there is no viewpoint.

    ground: the traversable cells.
    coverage: the cells that the camera has seen.
    here: the robot's cell.
    """
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
    path = Path(backtrack(waves[margin], place), masks[margin])
    return Viewpoint(place, path, max(MIN_GAIN_M2, KEPT_GAIN * float(gains[best])))


def _candidates(steps: Steps) -> Cells:
    """Return every fourth cell along rows and columns, (n, 2), if a path leads to it."""
    return np.argwhere(steps[::EVERY, ::EVERY] != UNREACHED) * EVERY


def _worths(gains: Areas, steps: Steps, cell: float) -> Areas:
    """Return for each cell the unseen area that is visible from it for each metre of cost, in m²/m.

    The value is 0 for cells that are too near to the robot or from which too little is visible.
    """
    lengths = steps * cell
    is_view = (gains >= MIN_GAIN_M2) & (lengths >= ELSEWHERE_M) & (steps != UNREACHED)
    return np.where(is_view, gains / (LOOK_ROUND_M + lengths), 0.0)
