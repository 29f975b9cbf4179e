"""What is free, what is taken, what is unknown: evidence from a range sensor, cell by cell."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.autonomy.navigation.grid_search import Cell, Mask
from robotcore.geometry import Pose

FREE_EVIDENCE = -1.5
TAKEN_EVIDENCE = 0.5

CERTAIN = 4.0
"""Evidence stays within ± this, so that a world that changes can be learnt again."""

SURELY_FREE = -3.0
"""Evidence of two readings that a cell is free, and of next to none that it is not."""

ABOUT = 2.5
"""How many cells before and behind an echo are about it: what is known a little wrong is no farther off."""

CLOSE_M = 0.6
"""An echo from nearer than this is believed. A cone of 30° is as wide as a gap for a small robot from 0.75 m on."""

_SQUARE = cv2.getStructuringElement(cv2.MORPH_RECT, (3, 3))

Metres = NDArray[np.float32]
Window = tuple[slice, slice]


class OccupancyGrid:
    """A square map round ``centre``, in the odometry's frame; ``size`` of its sides and of a ``cell``, in metres.

    The sensor hears the nearest thing in its cone: everything nearer is free, for certain; what is at the distance may
    be taken. So free weighs more than taken: Moravec and Elfes, High resolution maps from wide angle sonar, 1985.
    Arrays are indexed [row, column], y grows with the row, x with the column. ``evidence`` is below 0 where a cell is
    free, above 0 where it is taken; ``heard_from`` is from how near a cell was heard, in metres, inf where never.
    ``learnt_at`` is what ``moved`` was when something was last learnt of a cell; whoever moves the robot counts it up.
    """

    def __init__(self, size: float = 12.0, cell: float = 0.04, centre: tuple[float, float] = (0.0, 0.0)) -> None:
        self.cell = cell
        self.count = round(size / cell)
        self.evidence = np.zeros((self.count, self.count), dtype=np.float32)
        self.heard_from = np.full((self.count, self.count), np.inf, dtype=np.float32)
        self.learnt_at = np.zeros((self.count, self.count), dtype=np.float32)
        self.moved = 0.0
        middles = (np.arange(self.count) + 0.5) * cell - size / 2
        self._xs, self._ys = (middles + round(along / cell) * cell for along in centre)

    @property
    def taken(self) -> Mask:
        """Cells where something probably is."""
        return np.asarray(self.evidence > 0)

    @property
    def free(self) -> Mask:
        """Cells where nothing is."""
        return np.asarray(self.evidence < 0)

    @property
    def doubtful(self) -> Mask:
        """Cells that are taken as far as is known, but were only ever heard from afar: they may be a gap."""
        return self.taken & (self.heard_from > CLOSE_M)

    def cell_of(self, x: float, y: float) -> Cell:
        """Return row and column of a point; below 0, or from ``count`` on, where it lies outside."""
        row, column = (y - self._ys[0]) / self.cell, (x - self._xs[0]) / self.cell
        return math.floor(row + 0.5), math.floor(column + 0.5)

    def point_of(self, row: int, column: int) -> tuple[float, float]:
        """Return the middle of a cell."""
        return float(self._xs[column]), float(self._ys[row])

    def is_within(self, x: float, y: float, margin: float) -> bool:
        """Return whether a point lies at least ``margin`` metres inside the map."""
        west, east, south, north = self._xs[0], self._xs[-1], self._ys[0], self._ys[-1]
        return bool(min(x - west, east - x, y - south, north - y) > margin)

    def add_range(self, sensor: Pose, distance: float, max_range: float, cone: float) -> None:
        """Take in one reading; ``inf`` says that all the cone is free, ``cone`` is its full angle in radians."""
        reach = min(distance, max_range)
        window = self._window(sensor.x, sensor.y, reach + self.cell)
        in_cone, radius = self._cone(window, sensor, cone)
        patch, heard_from = self.evidence[window], self.heard_from[window]
        self.learnt_at[window][in_cone & (radius < reach + self.cell)] = self.moved
        patch[in_cone & (radius < reach - 0.5 * self.cell)] += FREE_EVIDENCE
        if distance <= max_range:
            echo = self._echo(patch > 0, in_cone, radius - distance)
            patch[echo] += TAKEN_EVIDENCE
            heard_from[echo] = np.minimum(heard_from[echo], distance)
        np.clip(patch, -CERTAIN, CERTAIN, out=patch)

    def add_free_disc(self, x: float, y: float, radius: float, certain: float) -> None:
        """Take in that nothing is within ``certain`` of a point, nor within ``radius`` where nothing was heard."""
        window = self._window(x, y, radius)
        patch, away = self.evidence[window], self._away(window, x, y)
        is_free = ((away <= radius) & (patch <= 0)) | (away <= certain)
        patch[is_free] = -CERTAIN
        self.learnt_at[window][is_free] = self.moved

    def is_refuted_by(self, sensor: Pose, distance: float, cone: float) -> bool:
        """Return whether an echo comes from the midst of what is surely free."""
        x, y = sensor.to_world(distance, 0.0)
        if not self.is_within(x, y, 0.0) or self.evidence[self.cell_of(x, y)] > SURELY_FREE:
            return False  # as nearly always: the rest takes as long as taking the reading in
        window, about = self._about(sensor, distance, cone)
        evidence = self.evidence[window][about]
        return bool((evidence <= SURELY_FREE).all())

    def forget_about(self, sensor: Pose, distance: float, cone: float) -> None:
        """Know nothing any more of where an echo comes from."""
        window, about = self._about(sensor, distance, cone)
        self.evidence[window][about] = 0.0

    def forget(self, cells: Mask) -> None:
        """Know nothing of some cells any more."""
        self.evidence[cells] = 0.0
        self.heard_from[cells] = np.inf

    def disc(self, x: float, y: float, radius: float) -> Mask:
        """Return which cells lie within a circle."""
        return np.asarray(self._away((slice(None), slice(None)), x, y) <= radius)

    def clearance(self, *, with_unknown: bool = True, overlook: Mask | None = None) -> Metres:
        """Return each cell's distance to the nearest that is taken (or unknown), in metres.

        Cells of ``overlook`` count as free.
        """
        open_cells = self._closed(self.free) & ~self.taken if with_unknown else ~self.taken
        if overlook is not None:
            open_cells = open_cells | overlook
        distance = cv2.distanceTransform(open_cells.astype(np.uint8), cv2.DIST_L2, 5)
        return np.asarray(distance * self.cell, dtype=np.float32)

    def _cone(self, window: Window, sensor: Pose, cone: float) -> tuple[Mask, NDArray[np.float64]]:
        """Return which cells of a window are in a cone, at its narrowest a cell wide, and how far away each one is."""
        dx, dy = self._xs[window[1]] - sensor.x, (self._ys[window[0]] - sensor.y)[:, None]
        cos, sin = math.cos(sensor.heading), math.sin(sensor.heading)
        ahead, aside = dx * cos + dy * sin, np.abs(dy * cos - dx * sin)
        in_cone = (ahead > 0) & (aside <= np.maximum(ahead * math.tan(cone / 2), self.cell / 2))
        return in_cone, np.hypot(ahead, aside)

    def _echo(self, taken: Mask, in_cone: Mask, beyond: NDArray[np.float64]) -> Mask:
        """Return which cells an echo speaks for: of its arc those known to be taken, which explain it; else all.

        Thrun, Learning occupancy grids with forward sensor models, 2003: cells of an arc are not independent.
        """
        known = in_cone & (np.abs(beyond) <= 1.5 * self.cell) & taken
        arc = in_cone & (beyond >= -0.5 * self.cell) & (beyond <= self.cell)
        return known if known.any() else arc

    def _about(self, sensor: Pose, distance: float, cone: float) -> tuple[Window, Mask]:
        """Return a window, and which of its cells are where an echo comes from, or next to it."""
        window = self._window(sensor.x, sensor.y, distance + ABOUT * self.cell)
        in_cone, radius = self._cone(window, sensor, cone)
        return window, in_cone & (np.abs(radius - distance) <= ABOUT * self.cell)

    def _away(self, window: Window, x: float, y: float) -> NDArray[np.float64]:
        """Return each cell's distance to a point, in metres."""
        return np.asarray(np.hypot(self._xs[window[1]] - x, (self._ys[window[0]] - y)[:, None]))

    def _window(self, x: float, y: float, reach: float) -> Window:
        """Return the part of the map that lies within ``reach`` of a point, along x and along y."""
        (top, left), (bottom, right) = self.cell_of(x - reach, y - reach), self.cell_of(x + reach, y + reach)
        return slice(max(top, 0), max(bottom + 1, 0)), slice(max(left, 0), max(right + 1, 0))

    @staticmethod
    def _closed(free: Mask) -> Mask:
        """Fill chinks of two cells: rays that a turn set apart leave them, and nothing stands in them."""
        return np.asarray(cv2.morphologyEx(free.astype(np.uint8), cv2.MORPH_CLOSE, _SQUARE), np.bool_)
