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
Areas = NDArray[np.float64]

VIEW_M = 1.8
CLOSE_M = 0.6
GUESS_M = 0.5
DOUBT = 0.25
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
        self.heard_from = np.full((self.count, self.count), np.inf, dtype=np.float32)
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
        patch[in_cone & (radius < reach - 0.5 * self.cell)] += FREE_EVIDENCE
        if distance <= max_range:
            beyond = radius - distance
            known = in_cone & (np.abs(beyond) <= 1.5 * self.cell) & (patch > 0)
            arc = in_cone & (beyond >= -0.5 * self.cell) & (beyond <= self.cell)
            echo = known if known.any() else arc
            patch[echo] += TAKEN_EVIDENCE
            heard = self.heard_from[window]
            heard[echo] = np.minimum(heard[echo], distance)
        np.clip(patch, -CERTAIN, CERTAIN, out=patch)

    def add_view(self, eye: Pose, field_of_view: float) -> None:
        """Take in that a camera looked: what is known to be free before it, within VIEW_M, need not be looked at again."""
        count = math.ceil(field_of_view / VIEW_RAY_RAD)
        angles = eye.heading + np.linspace(-field_of_view / 2, field_of_view / 2, count)
        rows, columns = self.rays(np.array([self.cell_of(eye.x, eye.y)]), angles, step=1)
        is_seen = np.logical_and.accumulate(self.evidence[rows, columns] < 0, axis=2)
        self.looked_at[rows[is_seen], columns[is_seen]] = True

    def unseen(self, cells: Cells, angles: Angles, step: int) -> Areas:
        """Return how much of what was not looked at may be seen from cells, (n, 2), in m² for each ray, (n, rays).

        Rays go every ``step`` cells up to VIEW_M, and end at what is taken; what is unknown may be free.
        """
        rows, columns, certain, possible = self._hidden(cells, angles, step)
        areas = np.arange(step, rows.shape[2] * step + 1, step) * (step * math.tau / len(angles) * self.cell**2)
        return np.asarray(((certain + DOUBT * (possible & ~certain)) * areas).sum(axis=2))

    def add_look_round(self, x: float, y: float) -> None:
        """Take in that a camera looked all round: what it could not see from here is not to be seen from here."""
        count = math.ceil(math.tau / VIEW_RAY_RAD)
        angles = np.linspace(0.0, math.tau, count)
        rows, columns, certain, possible = self._hidden(np.array([self.cell_of(x, y)]), angles, 1)
        self.looked_at[rows[possible], columns[possible]] = True

    def _hidden(self, cells: Cells, angles: Angles, step: int) -> tuple[Cells, Cells, Mask, Mask]:
        rows, columns = self.rays(cells, angles, step)
        taken = self.taken
        walls = np.asarray(cv2.dilate(taken.astype(np.uint8), _SQUARE), np.bool_)
        hard = np.asarray(cv2.dilate((taken & (self.heard_from <= CLOSE_M)).astype(np.uint8), _SQUARE), np.bool_)
        near = round(CLOSE_M / self.cell / step)
        ahead = walls[rows, columns]
        is_open = ~np.logical_or.accumulate(ahead, axis=2)
        ahead[:, :, :near] = hard[rows[:, :, :near], columns[:, :, :near]]
        may_be_open = ~np.logical_or.accumulate(ahead, axis=2)
        unknown = np.cumsum(self.evidence[rows, columns] >= 0, axis=2) * (step * self.cell)
        is_new = (unknown <= GUESS_M) & ~self.looked_at[rows, columns]
        return rows, columns, is_open & is_new, may_be_open & is_new

    def doubtful(self, cells: Cells, angles: Angles, step: int) -> Areas:
        """Return how much that is taken was never heard from near, about cells, (n, 2), in m² for each ray."""
        rows, columns = self.rays(cells, angles, step, CLOSE_M)
        taken = self.taken
        thick = np.asarray(cv2.dilate((taken & (self.heard_from > CLOSE_M)).astype(np.uint8), _SQUARE), np.bool_)
        before = np.logical_or.accumulate(taken[rows, columns], axis=2)
        return (thick[rows, columns] & ~np.roll(before, 1, axis=2)).any(axis=2) * 1.0

    def rays(self, cells: Cells, angles: Angles, step: int, reach: float = VIEW_M) -> tuple[Cells, Cells]:
        """Return rows and columns, each (n, rays, steps), of rays from cells, (n, 2)."""
        radii = np.arange(step, round(reach / self.cell) + 1, step)
        rows = cells[:, 0, None, None] + np.rint(np.sin(angles)[:, None] * radii).astype(int)
        columns = cells[:, 1, None, None] + np.rint(np.cos(angles)[:, None] * radii).astype(int)
        return rows.clip(0, self.count - 1), columns.clip(0, self.count - 1)

    def add_free_disc(self, x: float, y: float, radius: float, inner: float = 0.0) -> None:
        """Take in that nothing is round a point: the robot stands there."""
        window = self._window(Pose(x, y, 0.0), radius)
        dx = self._centres[window[1]] - x
        dy = (self._centres[window[0]] - y)[:, None]
        patch, away = self.evidence[window], np.hypot(dx, dy)
        patch[(away <= radius) & (patch <= 0) | (away <= inner)] = -CERTAIN

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
