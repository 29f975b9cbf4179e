"""Exploration: records the cells that the camera has seen, and chooses the next best view."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.autonomy.navigation.grid_paths import (
    SQUARE,
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
from robotcore.autonomy.navigation.planner import MARGINS_M, GridPath, Traversability
from robotcore.geometry import Pose

VIEW_M = 1.8
"""Cells farther from the camera than this do not count as seen, because the camera may miss a small ball there."""

GUESS_M = 0.5
"""The length of unknown cells along a ray through which the camera is assumed to see."""

GAP_PROBABILITY = 0.25
"""The probability that the camera sees through an uncertain cell. See `OccupancyGrid.uncertain`."""

MIN_TURN_M2 = 0.05
"""The robot turns to a bearing if at least this unseen area, in m², is visible there."""

FINE_RAD = 0.016
"""The angle between the rays that mark cells as seen. It is so small that they reach every cell within `VIEW_M`."""

COARSE_RAYS = 36
"""The number of rays over a full turn that estimate the unseen area around a cell."""

COARSE_CELLS = 2
"""The distance between successive points of one of these `COARSE_RAYS`, in cells."""

Areas = NDArray[np.float64]
Probabilities = NDArray[np.float64]


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
        """Mark all cells as seen that the camera may have seen in a full turn at a point. Call it after the turn."""
        angles = np.linspace(0.0, math.tau, math.ceil(math.tau / FINE_RAD))
        rays = self._rays(self._cell(x, y), angles, 1)
        self._mark_seen(rays, self._view_probabilities(rays, 1) > 0)

    def unseen_bearings(self, pose: Pose) -> Angles:
        """Return the bearings from a pose at which at least `MIN_TURN_M2` of unseen area is visible, in [-π, π)."""
        areas = self._measure_unseen_along_rays(self._cell(pose.x, pose.y))[0]
        around = areas + np.roll(areas, 1) + np.roll(areas, -1)
        return np.asarray((self._angles[around >= MIN_TURN_M2] - pose.heading + math.pi) % math.tau - math.pi)

    def gains(self, cells: Cells) -> Areas:
        """Return for each cell the unseen area that is visible from it, in m², (n,).

        cells: rows and columns, (n, 2).
        """
        return np.asarray(self._measure_unseen_along_rays(cells).sum(axis=1))

    def _measure_unseen_along_rays(self, cells: Cells) -> Areas:
        rays = self._rays(cells, self._angles, COARSE_CELLS)
        radii = COARSE_CELLS * np.arange(1, rays.rows.shape[2] + 1)
        areas = radii * (COARSE_CELLS * math.tau / COARSE_RAYS * self._grid.cell**2)
        return np.asarray((self._view_probabilities(rays, COARSE_CELLS) * areas).sum(axis=2))

    def _view_probabilities(self, rays: Rays, step: int) -> Probabilities:
        """Return for each cell along rays the probability that a camera at the ray's start sees it for the first time.

        The probability is 1, `GAP_PROBABILITY` or 0. From farther than `CLOSE_M`, an uncertain cell is opaque.
        """
        hides = self._mask_opaque(rays, self._grid.occupied)
        hides_surely = self._mask_opaque(rays, self._grid.occupied & ~self._grid.uncertain)
        is_near = np.arange(hides.shape[2]) < round(CLOSE_M / self._grid.cell / step)
        unknown = np.cumsum(~rays.of(self._grid.free), axis=2) * (step * self._grid.cell)
        is_new = (unknown <= GUESS_M) & ~rays.of(self.seen)
        chances = np.where(mask_hidden(np.where(is_near, hides_surely, hides)), 0.0, GAP_PROBABILITY)
        return np.asarray(np.where(mask_hidden(hides), chances, 1.0) * is_new)

    def _mask_opaque(self, rays: Rays, walls: Mask) -> Mask:
        """Return for each cell along rays whether it is opaque.

        Walls are widened by one cell, so that no ray passes between two cells that touch at a corner.
        """
        thick = np.asarray(cv2.dilate(walls.astype(np.uint8), SQUARE), np.bool_)
        return np.asarray(rays.of(thick) | ~rays.inside)

    def _mark_seen(self, rays: Rays, is_seen: Mask) -> None:
        self.seen[rays.rows[is_seen], rays.columns[is_seen]] = True

    def _rays(self, cells: Cells, angles: Angles, step: int) -> Rays:
        radii = np.arange(step, round(VIEW_M / self._grid.cell) + 1, step)
        return rays_from(cells, angles, radii, self._grid.count)

    def _cell(self, x: float, y: float) -> Cells:
        return np.array([self._grid.cell_of(x, y)])


MIN_GAIN_M2 = 0.1
"""A cell is a viewpoint only if at least this unseen area, in m², is visible from it."""

MIN_GAIN_SHARE = 0.3
"""The robot gives up a viewpoint if the camera has seen all but this fraction of the unseen area visible from there."""

MIN_VIEW_DISTANCE_M = 0.3
"""The least length of the path to a viewpoint. From nearer cells the camera sees the same as from here."""

FULL_TURN_COST_M = 1.2
"""The cost of the full turn at a viewpoint, in metres: the distance that the robot could drive in the same time."""

MARGIN_FACTOR = 0.85
"""The factor on a viewpoint's utility for each of `MARGINS_M` that is too wide for the path to the viewpoint."""

CANDIDATE_STRIDE = 4
"""A viewpoint is in every fourth row and column only, because the views from neighbouring cells are similar."""


class Viewpoint(NamedTuple):
    """A cell to which the robot drives to look around with its camera."""

    place: Cell
    path: GridPath
    """The path to the cell."""
    least_gain: float
    """The least unseen area visible from the cell, in m². If less is left, the robot gives up the viewpoint."""

    def is_worth_going(self, coverage: Coverage) -> bool:
        """Return whether at least `least_gain` of unseen area is still visible from the cell."""
        return bool(coverage.gains(np.array([self.place]))[0] >= self.least_gain)


def best_viewpoint(ground: Traversability, coverage: Coverage, here: Cell) -> Viewpoint | None:
    """Return the viewpoint with the greatest utility, or None if there is no viewpoint.

    The utility is the unseen area that is visible from the viewpoint, divided by the cost of the path plus the cost of
    a full turn there.

    ground: the traversable cells.
    coverage: the cells that the camera has seen.
    here: the robot's cell.
    """
    masks = ground.open_cells(here)
    waves = [wavefront(here, mask) for mask in masks]
    is_reached = waves[-1][::CANDIDATE_STRIDE, ::CANDIDATE_STRIDE] != UNREACHED
    cells = np.argwhere(is_reached) * CANDIDATE_STRIDE
    gains = coverage.gains(cells)
    utilities = np.stack([_compute_utilities(gains, wave[tuple(cells.T)], ground.grid.cell) for wave in waves])
    utilities *= MARGIN_FACTOR ** np.arange(len(MARGINS_M))[:, None]
    if not utilities.any():
        return None
    margin, best = np.unravel_index(int(utilities.argmax()), utilities.shape)
    place = int(cells[best, 0]), int(cells[best, 1])
    path = GridPath(backtrack(waves[margin], place), masks[margin])
    return Viewpoint(place, path, max(MIN_GAIN_M2, MIN_GAIN_SHARE * float(gains[best])))


def _compute_utilities(gains: Areas, steps: Steps, cell: float) -> Areas:
    """Return for each cell its utility in m²/m. It is 0 for a cell that cannot be a viewpoint.

    gains: the unseen area that is visible from each cell, in m².
    """
    lengths = steps * cell
    is_view = (gains >= MIN_GAIN_M2) & (lengths >= MIN_VIEW_DISTANCE_M) & (steps != UNREACHED)
    return np.where(is_view, gains / (FULL_TURN_COST_M + lengths), 0.0)
