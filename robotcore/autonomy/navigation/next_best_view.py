"""Exploration: the cells that a camera has seen, and the next best view, which shows most of the others."""

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
"""The distance up to which a view counts. Farther away the camera may miss a small ball."""

GUESS_M = 0.5
"""The length of unknown cells through which a view is assumed to pass."""

DOUBT = 0.25
"""The probability that an uncertain occupied cell is a gap, through which the camera sees."""

MIN_TURN_M2 = 0.05
"""The least unseen area for which the robot turns."""

FINE_RAD = 0.016
"""The angle between fine rays. They pass through each cell within `VIEW_M`."""

COARSE_RAYS = 36
"""The number of coarse rays over a full turn, for estimates of an area."""

COARSE_CELLS = 2
"""The distance between the points of a coarse ray, in cells."""

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
        """Mark the free cells before a camera as seen, up to `VIEW_M` or the first cell that is not free.

        eye: the camera's pose.
        field_of_view: its horizontal field of view in radians.
        """
        half = field_of_view / 2
        angles = eye.heading + np.linspace(-half, half, math.ceil(field_of_view / FINE_RAD))
        rays = self._rays(self._cell(eye.x, eye.y), angles, 1)
        self._mark_seen(rays, ~mask_hidden(~rays.of(self._grid.free)))

    def add_full_turn(self, x: float, y: float) -> None:
        """Mark all cells as seen that a camera might see in a full turn at a point. More is not visible from there."""
        angles = np.linspace(0.0, math.tau, math.ceil(math.tau / FINE_RAD))
        rays = self._rays(self._cell(x, y), angles, 1)
        self._mark_seen(rays, self._chances(rays, 1) > 0)

    def unseen_bearings(self, pose: Pose) -> Angles:
        """Return the bearings from a pose at which enough unseen area is visible, in [-π, π)."""
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
        """Return for each cell along rays the probability that it is unseen and visible: 1, `DOUBT` or 0.

        Unknown cells hide nothing for `GUESS_M`. Uncertain cells hide nothing, with the probability `DOUBT`, if they
        are nearer than `CLOSE_M` to the start of the ray: from there, the range sensor will measure them well.
        """
        hides = self._hides(rays, self._grid.taken)
        hides_surely = self._hides(rays, self._grid.taken & ~self._grid.uncertain)
        is_near = np.arange(hides.shape[2]) < round(CLOSE_M / self._grid.cell / step)
        unknown = np.cumsum(~rays.of(self._grid.free), axis=2) * (step * self._grid.cell)
        is_new = (unknown <= GUESS_M) & ~rays.of(self.seen)
        chances = np.where(mask_hidden(np.where(is_near, hides_surely, hides)), 0.0, DOUBT)
        return np.asarray(np.where(mask_hidden(hides), chances, 1.0) * is_new)

    def _hides(self, rays: Rays, walls: Mask) -> Mask:
        """Return the cells along rays that hide others. Walls are one cell thicker, so that no ray passes a corner."""
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
"""The least visible area of a viewpoint, in m²."""

KEPT_GAIN = 0.3
"""The robot gives up a viewpoint if less than this part of its visible area is still unseen."""

ELSEWHERE_M = 0.3
"""The least distance of a viewpoint. Nearer cells show the same as the robot's own cell."""

LOOK_ROUND_M = 1.2
"""The distance that the robot could drive in the time of a full turn."""

NARROW = 0.85
"""The factor on a viewpoint's worth for each margin of `MARGINS_M` that is too wide for its path."""

EVERY = 4
"""Only each fourth row and column is considered, because views from neighbouring cells are similar."""


class Viewpoint(NamedTuple):
    """A cell from which the camera should see its surroundings."""

    place: Cell
    path: Path
    """The path to the cell."""
    least_gain: float
    """The least unseen area, in m², for which the robot continues to the cell."""

    def is_worth_going(self, coverage: Coverage) -> bool:
        """Return whether enough unseen area is still visible from the cell."""
        return bool(coverage.gains(np.array([self.place]))[0] >= self.least_gain)


def best_viewpoint(ground: Traversability, coverage: Coverage, here: Cell) -> Viewpoint | None:
    """Return the next best view: the viewpoint with the largest unseen area for its path; None without one.

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
    """Return the considered cells, (n, 2), that a wave has reached. The narrowest margin reaches the most cells."""
    return np.argwhere(steps[::EVERY, ::EVERY] != UNREACHED) * EVERY


def _worths(gains: Areas, steps: Steps, cell: float) -> Areas:
    """Return the visible area of viewpoints for each metre of cost, in m²/m; 0 for cells that are no viewpoints."""
    lengths = steps * cell
    is_view = (gains >= MIN_GAIN_M2) & (lengths >= ELSEWHERE_M) & (steps != UNREACHED)
    return np.where(is_view, gains / (LOOK_ROUND_M + lengths), 0.0)
