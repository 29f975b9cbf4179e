"""Convex polygons, filled by the pixels whose centres lie in them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Point = Sequence[float]

SEAM = 1e-6
"""Neighbouring polygons overlap by this part of a pixel, so that rounding leaves no gap between them.

A level edge is looked at from as far inside, where it is no edge of either flank.
"""


def fill(canvas: NDArray[np.uint32], polygon: Sequence[Point], ink: int) -> None:
    """Give ``ink`` to the pixels of a polygon whose corners, (u, v), go round clockwise as seen.

    `cv2.fillConvexPoly` will not do: it paints half a pixel beyond each edge, and cannot be asked not to.
    """
    columns, rows = (
        _span(axis, size) for axis, size in zip(zip(*polygon, strict=True), canvas.shape[::-1], strict=True)
    )
    if len(columns) < len(rows):
        _fill_lines(canvas.T, [(v, u) for u, v in reversed(polygon)], columns, ink)
    else:
        _fill_lines(canvas, polygon, rows, ink)


def _span(places: Sequence[float], size: int) -> range:
    """Return the lines of the canvas that lie between the first and the last of some places."""
    return range(max(math.ceil(min(places)), 0), min(math.floor(max(places)), size - 1) + 1)


def _fill_lines(canvas: NDArray[np.uint32], polygon: Sequence[Point], lines: range, ink: int) -> None:
    if not lines:
        return
    heights = [v for _, v in polygon]
    levels = np.clip(np.arange(lines.start, lines.stop, dtype=np.float64), min(heights) + SEAM, max(heights) - SEAM)
    left, right = _flanks(polygon, heights)
    bounds = np.stack((_along(left, levels) - SEAM, _along(right, levels) + SEAM))
    begins, ends = np.clip(np.ceil(bounds), 0, canvas.shape[1]).astype(np.intp).tolist()
    for line, begin, end in zip(canvas[lines.start : lines.stop], begins, ends, strict=True):
        line[begin:end] = ink


def _flanks(polygon: Sequence[Point], heights: list[float]) -> tuple[Sequence[Point], Sequence[Point]]:
    """Return the corners from top to bottom, on the left and on the right."""
    top = heights.index(min(heights))
    ring = [*polygon[top:], *polygon[: top + 1]]
    bottom = (heights.index(max(heights)) - top) % len(polygon)
    return ring[bottom:][::-1], ring[: bottom + 1]


def _along(flank: Sequence[Point], levels: NDArray[np.float64]) -> NDArray[np.float64]:
    columns, heights = zip(*flank, strict=True)
    return np.asarray(np.interp(levels, heights, columns))
