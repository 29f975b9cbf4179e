"""An occupancy grid from the readings of a range sensor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.autonomy.navigation.grid_file import LAYERS, read_arrays, write_arrays
from robotcore.autonomy.navigation.grid_paths import SQUARE, Cell, Mask
from robotcore.autonomy.navigation.grid_picture import CellPose, draw_cells
from robotcore.canvas import encode_png
from robotcore.geometry import Pose
from robotcore.optics import Image

FREE_EVIDENCE = -1.5
"""A reading adds this to the evidence of each cell in the cone that is nearer to the sensor than the echo."""

OCCUPIED_EVIDENCE = 0.5
"""A reading adds this to the evidence of each cell in the cone at the distance of the echo."""

EVIDENCE_LIMIT = 4.0
"""The evidence of a cell is clipped to ± this value, so that a few readings can change an old cell."""

SURELY_FREE = -3.0
"""A cell with at most this evidence is surely free: two readings have shown it free, and no later echo was there."""

ECHO_TOLERANCE = 2.5
"""The cells that may belong to an echo lie within this distance, in cells, of the measured distance."""

NOISE_SIGMAS = 2.0
"""A reading shows nothing about cells that are nearer than the echo by less than this many standard deviations."""

CLOSE_M = 0.6
"""A cell with an echo from a sensor nearer than this is certainly occupied.

A farther echo marks a wider arc of cells, which may include a gap wide enough for a small robot.
"""

PICTURE_PX = 480
"""The width or the height of a map's picture in a notebook, in pixels."""

CLOSED_CELLS = 2
"""`OccupancyGrid.clearance` fills gaps between free cells of up to this width, in cells."""

Metres = NDArray[np.float32]
Indices = NDArray[np.intp]
"""The indices of cells in a flattened map, (n,)."""

Window = tuple[slice, slice]
"""The rows and the columns of a rectangle of cells."""

WHOLE: Window = slice(None), slice(None)
"""The window of the whole map."""


def get_corner(window: Window) -> Cell:
    """Return the row and the column of a window's first cell."""
    rows, columns = window
    return rows.start, columns.start


class OccupancyGrid:
    """A square map of free, occupied and unknown cells in the odometry's frame.

    A range sensor measures the distance to the nearest body in its cone. All cells in the cone that are nearer are
    surely free, but only some cells at this distance are occupied. So a reading counts more for free cells than for
    occupied cells. See Moravec and Elfes, High resolution maps from wide angle sonar, 1985.

    Arrays are indexed [row, column]. y grows with the row, x with the column.

    size: the length of the map's sides, in metres.
    cell: the length of a cell's sides, in metres.
    centre: the middle of the map, in metres.

    >>> from robotcore import Pose
    >>> grid = OccupancyGrid(size=4.0)
    >>> for _ in range(3):
    ...     grid.add_range(Pose(0.0, 0.0, 0.0), distance=1.0, max_range=2.0, cone=0.5)
    >>> grid
    <OccupancyGrid 4 x 4 m, cells of 0.04 m: 144 free, 22 occupied>
    >>> bool(grid.free[grid.cell_of(0.5, 0.0)]), bool(grid.occupied[grid.cell_of(1.0, 0.0)])
    (True, True)
    """

    def __init__(self, size: float = 12.0, cell: float = 0.04, centre: tuple[float, float] = (0.0, 0.0)) -> None:
        self.size, self.cell, self.centre = size, cell, centre
        self.count = round(size / cell)
        """The number of rows. The number of columns is the same."""
        self.evidence = np.zeros((self.count, self.count), dtype=np.float32)
        """Below 0 for a free cell, above 0 for an occupied cell, 0 for an unknown cell."""
        self.nearest_echo = np.full((self.count, self.count), np.inf, dtype=np.float32)
        """For each cell, the least distance at which the sensor received an echo from it, in metres; else ``inf``."""
        self.updated_at = np.zeros((self.count, self.count), dtype=np.float32)
        """The value of ``travelled`` at the last update of the cell."""
        self.travelled = 0.0
        """The robot's travel in metres plus its turns in radians. `MapMemory.move` increases it."""
        middles = (np.arange(self.count) + 0.5) * cell - size / 2
        self._xs, self._ys = (middles + round(steer / cell) * cell for steer in centre)
        self._west, self._east = float(self._xs[0]), float(self._xs[-1])
        self._south, self._north = float(self._ys[0]), float(self._ys[-1])

    def __repr__(self) -> str:
        counts = f"{int(self.free.sum())} free, {int(self.occupied.sum())} occupied"
        side = self.count * self.cell
        return f"<OccupancyGrid {side:g} x {side:g} m, cells of {self.cell:g} m: {counts}>"

    def save(self, file: str | Path) -> None:
        """Write the map into a file ``.npz`` of NumPy.

        Raises MapError if the file cannot be written, or if the map is larger or farther away than `load` accepts.
        """
        (x, y), travelled = self.centre, self.travelled
        scalars = {"size_m": self.size, "cell_m": self.cell, "centre_x_m": x, "centre_y_m": y, "travelled": travelled}
        layers = (self.evidence, self.nearest_echo, self.updated_at)
        write_arrays(Path(file), scalars, dict(zip(LAYERS, layers, strict=True)))

    @classmethod
    def load(cls, file: str | Path) -> OccupancyGrid:
        """Return the map in a file that `save` has written.

        Raises MapError if the file does not exist, is damaged or is no map. The file's values cannot run code.
        """
        scalars, layers = read_arrays(Path(file))
        grid = cls(scalars["size_m"], scalars["cell_m"], (scalars["centre_x_m"], scalars["centre_y_m"]))
        grid.travelled = scalars["travelled"]
        grid.evidence, grid.nearest_echo, grid.updated_at = (layers[name] for name in LAYERS)
        return grid

    def draw(self, pose: Pose | None = None, path: Sequence[tuple[float, float]] = (), size: int = PICTURE_PX) -> Image:
        """Return a BGR picture of the known part of the map: free cells white, occupied dark, and unknown grey.

        pose: the robot's pose, drawn as an arrow; None to draw no robot. A pose outside the map is not drawn.
        path: the points of a path in metres, drawn as a line. Points outside the map are left out.
        size: the greatest width and height of the picture, in pixels.
        """
        is_drawn = pose and math.isfinite(pose.heading) and self.is_within(pose.x, pose.y, 0.0)
        robot = CellPose(*self._to_cells(pose.x, pose.y), pose.heading) if pose and is_drawn else None
        points = [self._to_cells(x, y) for x, y in path if self.is_within(x, y, 0.0)]
        return draw_cells(self.free, self.occupied, robot, points, size)

    def _repr_png_(self) -> bytes:
        return encode_png(self.draw())

    def _to_cells(self, x: float, y: float) -> tuple[float, float]:
        return (y - self._south) / self.cell, (x - self._west) / self.cell

    @property
    def occupied(self) -> Mask:
        """The cells that are probably occupied."""
        return np.asarray(self.evidence > 0)

    @property
    def free(self) -> Mask:
        """The cells that are free."""
        return np.asarray(self.evidence < 0)

    @property
    def uncertain(self) -> Mask:
        """The occupied cells whose echoes all came from farther than `CLOSE_M`. Such a cell may be a gap."""
        return self.occupied & (self.nearest_echo > CLOSE_M)

    def cell_of(self, x: float, y: float) -> Cell:
        """Return the row and the column of a point (x, y) in metres.

        If the point is outside the map, the row or the column is below 0, or at least ``count``.
        """
        row, column = self._to_cells(x, y)
        return math.floor(row + 0.5), math.floor(column + 0.5)

    def point_of(self, row: int, column: int) -> tuple[float, float]:
        """Return the middle of a cell, in metres."""
        return float(self._xs[column]), float(self._ys[row])

    def is_within(self, x: float, y: float, margin: float) -> bool:
        """Return whether a point lies at least ``margin`` metres inside the map."""
        return min(x - self._west, self._east - x, y - self._south, self._north - y) > margin

    def add_range(self, sensor: Pose, distance: float, max_range: float, cone: float, noise: float = 0.0) -> None:
        """Update the map with a reading of the range sensor.

        sensor: the sensor's pose.
        distance: the measured distance in metres; ``inf`` without an echo, so that the whole cone is free.
        max_range: the sensor's range in metres.
        cone: the full opening angle of the cone in radians.
        noise: the standard deviation of the distance in metres.
        """
        reach = min(distance, max_range)
        cells, radius = self._find_cone(sensor, reach + self.cell, cone)
        self.updated_at.put(cells[radius < reach + self.cell], self.travelled)
        evidence = self.evidence.take(cells)
        evidence[radius < reach - 0.5 * self.cell - NOISE_SIGMAS * noise] += FREE_EVIDENCE
        if distance <= max_range:
            is_echo = self._mask_echo(evidence > 0, radius - distance)
            evidence[is_echo] += OCCUPIED_EVIDENCE
            echo = cells[is_echo]
            self.nearest_echo.put(echo, np.minimum(self.nearest_echo.take(echo), distance))
        self.evidence.put(cells, np.minimum(np.maximum(evidence, -EVIDENCE_LIMIT), EVIDENCE_LIMIT))

    def add_free_disc(self, x: float, y: float, radius: float, certain: float) -> None:
        """Mark the cells around a point as free, such as the floor under the robot.

        x, y: the point, in metres.
        radius: the distance in metres within which unknown cells become free.
        certain: the distance in metres within which occupied cells become free too.
        """
        window = self._window(x, y, radius)
        patch, away = self.evidence[window], self._away(window, x, y)
        is_free = ((away <= radius) & (patch <= 0)) | (away <= certain)
        patch[is_free] = -EVIDENCE_LIMIT
        self.updated_at[window][is_free] = self.travelled

    def contradicts_echo(self, sensor: Pose, distance: float, cone: float) -> bool:
        """Return whether an echo contradicts the map: all cells at its position and next to it are surely free."""
        x, y = sensor.to_world(distance, 0.0)
        if not self.is_within(x, y, 0.0) or self.evidence[self.cell_of(x, y)] > SURELY_FREE:
            return False  # Nearly every call ends here. The rest of the method takes as long as `add_range`.
        return bool((self.evidence.take(self._find_echo_area(sensor, distance, cone)) <= SURELY_FREE).all())

    def clear_echo(self, sensor: Pose, distance: float, cone: float) -> None:
        """Mark the cells at the position of an echo and next to it as unknown."""
        self.evidence.put(self._find_echo_area(sensor, distance, cone), 0.0)

    def forget(self, cells: Mask) -> None:
        """Mark cells as unknown."""
        self.evidence[cells] = 0.0
        self.nearest_echo[cells] = np.inf

    def disc(self, x: float, y: float, radius: float) -> Mask:
        """Return the mask of the cells in a circle, given by its centre and its radius in metres."""
        mask, window = np.zeros_like(self.evidence, np.bool_), self._window(x, y, radius)
        mask[window] = self._away(window, x, y) <= radius
        return mask

    def find_window(self, cells: Sequence[Cell], clearance: float) -> Window:
        """Return a window around cells in which `clearance` computes their clearances up to a limit.

        cells: the cells. The window contains those of them that are on the map, and at least one cell.
        clearance: the limit in metres. In the window, a greater clearance may be too great.
        """
        margin = math.ceil(clearance / self.cell) + CLOSED_CELLS
        rows, columns = (
            slice(max(min(min(at) - margin, self.count - 1), 0), max(min(max(at) + margin + 1, self.count), 1))
            for at in zip(*cells, strict=True)
        )
        return rows, columns

    def clearance(self, *, with_unknown: bool = True, overlook: Mask | None = None, window: Window = WHOLE) -> Metres:
        """Return the distance of each cell to the nearest occupied cell, in metres.

        with_unknown: whether unknown cells count as occupied.
        overlook: cells that count as free.
        window: the part of the map to compute, see `find_window`.
        """
        evidence = self.evidence[window]
        open_cells = evidence <= 0
        if with_unknown:
            # A turning sensor leaves gaps of up to two cells between the cones of successive readings.
            closed = cv2.morphologyEx((evidence < 0).view(np.uint8), cv2.MORPH_CLOSE, SQUARE)
            open_cells &= np.asarray(closed, np.bool_)
        if overlook is not None:
            open_cells |= overlook[window]
        distance = cv2.distanceTransform(open_cells.view(np.uint8), cv2.DIST_L2, 5)
        return np.asarray(distance * self.cell, dtype=np.float32)

    def _find_cone(self, sensor: Pose, reach: float, cone: float) -> tuple[Indices, NDArray[np.float64]]:
        """Return the cells in the sensor's cone, and each cell's distance from the sensor in metres, (n,).

        Near the sensor, the cone is as wide as a cell. Some of the cells are a little farther away than ``reach``. They
        lie in the square around the sensor whose sides are ``2 * reach`` metres long.
        """
        (x, y, _), cos, sin = sensor, math.cos(sensor.heading), math.sin(sensor.heading)
        slope, narrow, far = math.tan(cone / 2), self.cell / 2, reach + self.cell
        # The rectangle around the cone's four corners is far smaller than the square.
        wide, tip_x, tip_y = max(far * slope, narrow), x + far * cos, y + far * sin
        rows, columns = self._find_rectangle(
            max(x - reach, min(x - narrow * abs(sin), tip_x - wide * abs(sin))),
            max(y - reach, min(y - narrow * abs(cos), tip_y - wide * abs(cos))),
            min(x + reach, max(x + narrow * abs(sin), tip_x + wide * abs(sin))),
            min(y + reach, max(y + narrow * abs(cos), tip_y + wide * abs(cos))),
        )
        dx, dy = self._xs[columns] - x, (self._ys[rows] - y)[:, None]
        ahead, aside = dx * cos + dy * sin, np.abs(dy * cos - dx * sin)
        is_inside = (ahead > 0) & (aside <= np.maximum(ahead * slope, narrow))
        (inside,) = is_inside.reshape(-1).nonzero()
        width = max(ahead.shape[1], 1)
        # Each row of the map has this number of cells more than a row of the rectangle.
        cells = inside + inside // width * (self.count - width) + (rows.start * self.count + columns.start)
        return cells, np.hypot(ahead.take(inside), aside.take(inside))

    def _mask_echo(self, occupied: Mask, beyond: NDArray[np.float64]) -> Mask:
        """Return for each cell of a cone whether it may have caused an echo, (n,).

        These are the occupied cells at the echo's distance. Without such a cell, they are all cells at that distance.
        See Thrun, Learning occupancy grids with forward sensor models, 2003.

        beyond: each cell's distance from the sensor minus the echo's, in metres.
        """
        known = (np.abs(beyond) <= 1.5 * self.cell) & occupied
        return known if np.count_nonzero(known) else (beyond >= -0.5 * self.cell) & (beyond <= self.cell)

    def _find_echo_area(self, sensor: Pose, distance: float, cone: float) -> Indices:
        tolerance = ECHO_TOLERANCE * self.cell
        cells, radius = self._find_cone(sensor, distance + tolerance, cone)
        return np.asarray(cells[np.abs(radius - distance) <= tolerance])

    def _away(self, window: Window, x: float, y: float) -> NDArray[np.float64]:
        return np.asarray(np.hypot(self._xs[window[1]] - x, (self._ys[window[0]] - y)[:, None]))

    def _window(self, x: float, y: float, reach: float) -> Window:
        """Return the window of a square around (x, y). Each side is ``2 * reach`` metres long."""
        return self._find_rectangle(x - reach, y - reach, x + reach, y + reach)

    def _find_rectangle(self, west: float, south: float, east: float, north: float) -> Window:
        """Return the window of the cells between two x and two y coordinates, in metres."""
        (top, left), (bottom, right) = self.cell_of(west, south), self.cell_of(east, north)
        return slice(max(top, 0), max(bottom + 1, 0)), slice(max(left, 0), max(right + 1, 0))
