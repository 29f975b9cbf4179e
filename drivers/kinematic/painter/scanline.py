"""Convex polygons, filled by the pixels whose centres lie in them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Point = Sequence[float]

SEAM = 1e-6
"""Neighbouring polygons overlap by this part of a pixel, so that rounding leaves no gap between them."""


def fill(canvas: NDArray[np.uint32], polygon: Sequence[Point], ink: int) -> None:
    """Give ``ink`` to the pixels of a polygon whose corners, (u, v), go round clockwise as seen.

    `cv2.fillConvexPoly` will not do: it paints half a pixel beyond each edge, and cannot be asked not to.
    """
    heights = [v for _, v in polygon]
    first = max(math.ceil(min(heights)), 0)
    last = min(math.floor(max(heights)), canvas.shape[0] - 1)
    if first > last:
        return
    rows = np.arange(first, last + 1)
    left, right = _flanks(polygon, heights)
    begins = _columns(np.ceil(_along(left, rows) - SEAM), canvas.shape[1])
    ends = _columns(np.floor(_along(right, rows) + SEAM) + 1, canvas.shape[1])
    for row, begin, end in zip(canvas[first : last + 1], begins, ends, strict=True):
        row[begin:end] = ink


def _flanks(polygon: Sequence[Point], heights: list[float]) -> tuple[Sequence[Point], Sequence[Point]]:
    """Return the corners from top to bottom, on the left and on the right."""
    top = heights.index(min(heights))
    ring = [*polygon[top:], *polygon[: top + 1]]
    bottom = (heights.index(max(heights)) - top) % len(polygon)
    return ring[bottom:][::-1], ring[: bottom + 1]


def _along(flank: Sequence[Point], rows: NDArray[np.intp]) -> NDArray[np.float64]:
    columns, heights = zip(*flank, strict=True)
    return np.asarray(np.interp(rows, heights, columns))


def _columns(columns: NDArray[np.float64], width: int) -> list[int]:
    clipped: list[int] = np.clip(columns, 0, width).astype(np.intp).tolist()
    return clipped
