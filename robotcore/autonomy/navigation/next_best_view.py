"""Exploration: records the cells that the camera has seen, and chooses the next best view."""

from __future__ import annotations

import math
from functools import lru_cache
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
    Rays,
    Steps,
    backtrack,
    compute_rays,
    cut_out,
    mask_hidden,
    set_outside,
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


OPACITY_BITS, UNKNOWN_BIT, SEEN_BIT = 3, 4, 8
"""The bits of a cell's code. Its opacity is 0, or 1 for an opaque cell, or 2 for a surely opaque one."""


class Coverage:
    """The cells of a map that the camera has seen."""

    def __init__(self, grid: OccupancyGrid) -> None:
        self.seen = np.zeros_like(grid.evidence, np.bool_)
        """Whether the camera has seen a cell, as a mask of the grid."""
        self._grid = grid
        self._reach = round(VIEW_M / grid.cell)
        self._angles = np.linspace(0.0, math.tau, COARSE_RAYS, endpoint=False, dtype=np.float64)
        self._radii = np.arange(1, self._reach + 1)
        radii = self._radii[COARSE_CELLS - 1 :: COARSE_CELLS]
        self._coarse_rays = compute_rays(self._angles, radii)
        self._areas = radii * (COARSE_CELLS * math.tau / COARSE_RAYS * grid.cell**2)

    def add_view(self, eye: Pose, field_of_view: float) -> None:
        """Mark the free cells in a camera's field of view as seen.

        Cells that are farther than `VIEW_M`, or behind a cell that is not free, are not marked.

        eye: the camera's pose.
        field_of_view: the camera's horizontal field of view in radians.
        """
        (row, column), count = self._grid.cell_of(eye.x, eye.y), self._grid.count
        rays = compute_rays(eye.heading + _spread_angles(field_of_view), self._radii)
        cells = rays.index(count) + (row * count + column)
        is_free = self._grid.evidence.take(cells, mode="clip") < 0
        if not self._reach <= min(row, column) <= max(row, column) < count - self._reach:
            is_free &= rays.lie_within(-row, -column, count)
        self.seen.put(cells[np.logical_and.accumulate(is_free, axis=1)], True)

    def add_full_turn(self, x: float, y: float) -> None:
        """Mark all cells as seen that the camera may have seen in a full turn at a point. Call it after the turn."""
        (row, column), count = self._grid.cell_of(x, y), self._grid.count
        rays = compute_rays(np.linspace(0.0, math.tau, math.ceil(math.tau / FINE_RAD)), self._radii)
        is_seen = self._view_probabilities(np.array([(row, column)]), rays, 1)[0] > 0
        self.seen.put(rays.index(count)[is_seen] + row * count + column, True)

    def unseen_bearings(self, pose: Pose) -> Angles:
        """Return the bearings from a pose at which at least `MIN_TURN_M2` of unseen area is visible, in [-π, π)."""
        areas = self._measure_unseen_along_rays(np.array([self._grid.cell_of(pose.x, pose.y)]))[0]
        ring = np.concatenate((areas[-1:], areas, areas[:1]))
        around = areas + ring[:-2] + ring[2:]
        return np.asarray((self._angles[around >= MIN_TURN_M2] - pose.heading + math.pi) % math.tau - math.pi)

    def gains(self, cells: Cells) -> Areas:
        """Return for each cell the unseen area that is visible from it, in m², (n,).

        cells: rows and columns, (n, 2).
        """
        return np.asarray(self._measure_unseen_along_rays(cells).sum(axis=1))

    def _measure_unseen_along_rays(self, cells: Cells) -> Areas:
        return np.asarray((self._view_probabilities(cells, self._coarse_rays, COARSE_CELLS) * self._areas).sum(axis=2))

    def _view_probabilities(self, starts: Cells, rays: Rays, step: int) -> Probabilities:
        """Return for each cell along rays the probability that a camera at the ray's start sees it for the first time.

        The probability is 1, `GAP_PROBABILITY` or 0. From farther than `CLOSE_M`, an uncertain cell is opaque. The
        result has the shape (starts, angles, radii).

        step: the distance between successive cells of a ray, in cells.
        """
        if not len(starts):
            return np.zeros((0, *rays.rows.shape))
        low = starts.min(axis=0) - self._reach
        codes = self._encode_cells(low, starts.max(axis=0) + self._reach)
        first = (starts - low) @ (codes.shape[1], 1)
        along = codes.take(first[:, None, None] + rays.index(codes.shape[1]))
        opacity = along & OPACITY_BITS
        is_near = np.arange(along.shape[2]) < round(CLOSE_M / self._grid.cell / step)
        unknown = np.cumsum(along & UNKNOWN_BIT > 0, axis=2, dtype=np.uint8) * (step * self._grid.cell)
        is_new = (unknown <= GUESS_M) & (along & SEEN_BIT == 0)
        chances = np.where(mask_hidden(opacity > is_near), 0.0, GAP_PROBABILITY)
        return np.asarray(np.where(mask_hidden(opacity > 0), chances, 1.0) * is_new)

    def _encode_cells(self, low: Cells, high: Cells) -> NDArray[np.uint8]:
        """Return the codes of all cells between two corners of a rectangle, both included.

        Walls are widened by one cell, so that no ray passes between two cells that touch at a corner. Cells outside the
        map are surely opaque.
        """
        (top, left), (bottom, right) = low.tolist(), high.tolist()
        wider = (top - 1, left - 1), (bottom + 1, right + 1)
        evidence, nearest_echo = (cut_out(each, *wider) for each in (self._grid.evidence, self._grid.nearest_echo))
        walls = evidence > 0
        set_outside(walls, wider[0], self.seen.shape, False)
        opacity = walls.view(np.uint8) + (walls & (nearest_echo <= CLOSE_M))
        opacity = np.asarray(cv2.dilate(opacity, SQUARE), np.uint8)[1:-1, 1:-1]
        is_unknown, is_seen = evidence[1:-1, 1:-1] >= 0, cut_out(self.seen, (top, left), (bottom, right))
        codes = opacity + UNKNOWN_BIT * is_unknown.view(np.uint8) + SEEN_BIT * is_seen.view(np.uint8)
        set_outside(codes, (top, left), self.seen.shape, 2 + UNKNOWN_BIT)
        return codes


@lru_cache(maxsize=1)
def _spread_angles(field_of_view: float) -> Angles:
    """Return the angles of the rays in a field of view, relative to its middle, in radians."""
    half = field_of_view / 2
    return np.linspace(-half, half, math.ceil(field_of_view / FINE_RAD))


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
