"""Draws the cells of a map as a picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from robotcore.autonomy.navigation.grid_paths import Mask
from robotcore.canvas import BAD, INK, PAPER, SERIES, Colour
from robotcore.optics import Image

UNKNOWN: Colour = (200, 203, 209)
"""The colour of unknown cells. Free cells have the colour PAPER, and occupied cells INK."""

MARGIN_CELLS = 8
"""The width of the margin around the drawn cells."""

MIN_CELLS = 50
"""The least width and height of the drawn part of a map, in cells."""

ARROW_CELLS = 5.0
"""The length of the arrow that shows the robot, in cells."""


class CellPose(NamedTuple):
    """A pose on the grid. The row and the column count in cells, and may be fractions."""

    row: float
    column: float
    heading: float
    """The angle from the direction of growing columns, in radians, positive towards growing rows."""


def draw_cells(
    free: Mask, occupied: Mask, robot: CellPose | None, path: Sequence[tuple[float, float]], size: int
) -> Image:
    """Return a BGR picture of the known part of a map, in which the row grows upward.

    robot: the robot's pose; None to draw no robot.
    path: the row and the column of each point of a path.
    size: the greatest width and height of the picture, in pixels.
    """
    cells = np.full((*free.shape, 3), UNKNOWN[::-1], np.uint8)
    cells[free], cells[occupied] = PAPER[::-1], INK[::-1]
    points = [*path, (robot.row, robot.column)] if robot else list(path)
    rows = _find_span([*np.flatnonzero((free | occupied).any(axis=1)), *(row for row, _ in points)], len(free))
    columns = _find_span([*np.flatnonzero((free | occupied).any(axis=0)), *(column for _, column in points)], len(free))
    part = cells[rows, columns]
    scale = size / max(part.shape[:2])
    shape = round(part.shape[1] * scale), round(part.shape[0] * scale)
    picture = np.asarray(cv2.resize(part[::-1], shape, interpolation=cv2.INTER_NEAREST), np.uint8)

    def to_pixel(row: float, column: float) -> tuple[int, int]:
        return round((column - columns.start + 0.5) * scale), round((rows.stop - row - 0.5) * scale)

    line = np.array([to_pixel(*point) for point in path], np.int32).reshape(-1, 1, 2)
    cv2.polylines(picture, [line], False, SERIES[0][::-1], max(2, round(scale / 2)), cv2.LINE_AA)
    if robot:
        tip = (
            robot.row + ARROW_CELLS * math.sin(robot.heading),
            robot.column + ARROW_CELLS * math.cos(robot.heading),
        )
        thickness = max(2, round(scale / 2))
        cv2.arrowedLine(
            picture, to_pixel(robot.row, robot.column), to_pixel(*tip), BAD[::-1], thickness, cv2.LINE_AA, tipLength=0.5
        )
    return picture


def _find_span(indices: Sequence[float], count: int) -> slice:
    """Return the slice of at least `MIN_CELLS` rows or columns that contains these indices and a margin."""
    middle = count / 2
    low, high = min(indices, default=middle) - MARGIN_CELLS, max(indices, default=middle) + MARGIN_CELLS
    spare = max(0.0, (MIN_CELLS - (high - low)) / 2)
    return slice(max(0, math.floor(low - spare)), min(count, math.ceil(high + spare) + 1))
