"""What is free, what is taken, what is unknown: evidence from a range sensor, cell by cell."""

from __future__ import annotations

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.geometry import Pose

_SQUARE = cv2.getStructuringElement(cv2.MORPH_RECT, (3, 3))

Mask = NDArray[np.bool_]
Cells = NDArray[np.intp]
Angles = NDArray[np.float64]

VIEW_M = 2.5
VIEW_RAY_RAD = 0.016

FREE_EVIDENCE = -1.5
TAKEN_EVIDENCE = 0.5
CERTAIN = 4.0
"""Evidence stays within ± this, so that a world that changes can be learnt again."""


class OccupancyGrid:
    """A square map around the origin of the odometry's frame; and which of it a camera has looked at.

    The sensor hears the nearest thing in its cone: everything nearer is free, for certain; what is at the distance may
    be taken. So free weighs more than taken: Moravec and Elfes, High resolution maps from wide angle sonar, 1985.
    Arrays are indexed [row, column], y grows with the row, x with the column.
    """

    def __init__(self, size: float = 12.0, cell: float = 0.04) -> None:
        self.cell = cell
        self.count = round(size / cell)
        self.evidence = np.zeros((self.count, self.count), dtype=np.float32)
        self.looked_at = np.zeros((self.count, self.count), dtype=np.bool_)
        self._centres = (np.arange(self.count) + 0.5) * cell - size / 2

    @property
    def taken(self) -> Mask:
        """Cells where something probably is."""
        return np.asarray(self.evidence > 0)

    @property
    def free(self) -> Mask:
        """Cells where nothing is."""
        return np.asarray(self.evidence < 0)

    def cell_of(self, x: float, y: float) -> tuple[int, int]:
        """Return row and column of a point; the border where it lies outside."""
        last = self.count - 1
        column = min(max(int((x - self._centres[0]) / self.cell + 0.5), 0), last)
        row = min(max(int((y - self._centres[0]) / self.cell + 0.5), 0), last)
        return row, column

    def point_of(self, row: int, column: int) -> tuple[float, float]:
        """Return the middle of a cell."""
        return float(self._centres[column]), float(self._centres[row])

    def add_range(self, sensor: Pose, distance: float, max_range: float, cone: float) -> None:
        """Take in one reading; ``inf`` says that all the cone is free."""
        reach = min(distance, max_range)
        window = self._window(sensor, reach + self.cell)
        dx = self._centres[window[1]] - sensor.x
        dy = (self._centres[window[0]] - sensor.y)[:, None]
        cos, sin = math.cos(sensor.heading), math.sin(sensor.heading)
        ahead, aside = dx * cos + dy * sin, np.abs(dy * cos - dx * sin)
        in_cone = (ahead > 0) & (aside <= np.maximum(ahead * math.tan(cone / 2), self.cell / 2))
        radius = np.hypot(ahead, aside)
        patch = self.evidence[window]
        patch[in_cone & (radius < reach - self.cell)] += FREE_EVIDENCE
        if distance <= max_range:
            patch[in_cone & (np.abs(radius - distance) <= 0.75 * self.cell)] += TAKEN_EVIDENCE
        np.clip(patch, -CERTAIN, CERTAIN, out=patch)

    def add_view(self, eye: Pose, field_of_view: float) -> None:
        """Take in that a camera looked: what nothing hides, within VIEW_M, need not be looked at again."""
        count = math.ceil(field_of_view / VIEW_RAY_RAD)
        angles = eye.heading + np.linspace(-field_of_view / 2, field_of_view / 2, count)
        rows, columns, is_seen = self.rays(np.array([self.cell_of(eye.x, eye.y)]), angles, step=1)
        self.looked_at[rows[is_seen], columns[is_seen]] = True

    def rays(self, cells: Cells, angles: Angles, step: int) -> tuple[Cells, Cells, Mask]:
        """Follow rays from cells, (n, 2), every ``step`` cells up to VIEW_M.

        Return rows, columns, and whether they are in sight, each (n, rays, steps): nothing that is taken comes before.
        """
        radii = np.arange(step, round(VIEW_M / self.cell) + 1, step)
        rows = cells[:, 0, None, None] + np.rint(np.sin(angles)[:, None] * radii).astype(int)
        columns = cells[:, 1, None, None] + np.rint(np.cos(angles)[:, None] * radii).astype(int)
        rows, columns = rows.clip(0, self.count - 1), columns.clip(0, self.count - 1)
        return rows, columns, ~np.logical_or.accumulate(self.evidence[rows, columns] > 0, axis=2)

    def add_free_disc(self, x: float, y: float, radius: float) -> None:
        """Take in that nothing is round a point: the robot stands there."""
        window = self._window(Pose(x, y, 0.0), radius)
        dx = self._centres[window[1]] - x
        dy = (self._centres[window[0]] - y)[:, None]
        self.evidence[window][np.hypot(dx, dy) <= radius] = -CERTAIN

    def disc(self, x: float, y: float, radius: float) -> Mask:
        """Return which cells lie within a circle."""
        dx, dy = self._centres - x, (self._centres - y)[:, None]
        return np.asarray(np.hypot(dx, dy) <= radius)

    def clearance(self, *, with_unknown: bool = True, overlook: Mask | None = None) -> NDArray[np.float32]:
        """Return each cell's distance to the nearest that is taken (or unknown), in metres.

        Cells of ``overlook`` count as free.
        """
        open_cells = self._closed(self.free) & ~self.taken if with_unknown else ~self.taken
        if overlook is not None:
            open_cells = open_cells | overlook
        distance = cv2.distanceTransform(open_cells.astype(np.uint8), cv2.DIST_L2, 5)
        return np.asarray(distance * self.cell, dtype=np.float32)

    @staticmethod
    def _closed(free: Mask) -> Mask:
        """Fill chinks of two cells: rays that a turn set apart leave them, and nothing stands in them."""
        return np.asarray(cv2.morphologyEx(free.astype(np.uint8), cv2.MORPH_CLOSE, _SQUARE), np.bool_)

    def _window(self, around: Pose, reach: float) -> tuple[slice, slice]:
        top, left = self.cell_of(around.x - reach, around.y - reach)
        bottom, right = self.cell_of(around.x + reach, around.y + reach)
        return slice(top, bottom + 1), slice(left, right + 1)
