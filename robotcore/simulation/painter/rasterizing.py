"""Find the pixels of convex polygons, as rectangles that NumPy fills.

`cv2.fillConvexPoly` is not exact enough, because it paints half a pixel beyond each edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.simulation.painter.planes import Array

SEAM = 1e-6
"""The overlap of neighbouring polygons in pixels, so that rounding leaves no gap between them.

A polygon's first and last line move inwards by the same distance. Then each line crosses an edge on both sides.
"""


class Area(NamedTuple):
    """The pixels of a polygon in a picture."""

    box: Sequence[float]
    """The left, top, right and bottom edge of the polygon's bounding box, in pixels."""
    rectangles: Sequence[Sequence[int]]
    """Rectangles that together are the polygon: the first row, the row after the last one, and the same of columns."""

    def fill(self, canvas: NDArray[Any], value: int) -> None:
        """Write a value to all pixels of the polygon."""
        for top, bottom, left, right in self.rectangles:
            canvas[top:bottom, left:right] = value


class _Lines(NamedTuple):
    """The lines of n polygons, along the axis u. The axis v numbers them. Each array is (n,), in pixels."""

    is_upright: NDArray[np.bool_]
    """Whether the lines are columns. Else they are rows."""
    length: Array
    """The length of a line of the picture."""
    low: Array
    """The least v of the polygon."""
    high: Array
    """The greatest v of the polygon."""
    first: Array
    """The v of the polygon's first line."""
    stop: Array
    """The v after the polygon's last line."""
    start: Array
    """The index of the polygon's first line among the lines of all polygons."""
    total: int
    """The number of lines of all polygons."""


def fill(canvas: NDArray[Any], polygon: Sequence[Sequence[float]], value: int) -> None:
    """Write a value to all pixels of a convex polygon. The corners, (u, v), are clockwise in the picture."""
    height, width = canvas.shape
    (area,) = rasterize(np.array(polygon, dtype=np.float64).T[:, :, None], width, height)
    area.fill(canvas, value)


def rasterize(polygons: Array, width: int, height: int) -> list[Area]:
    """Return the pixels of n convex polygons in a picture.

    A polygon consists of lines: rows, or columns if it has fewer of them. Successive lines from the same pixel to the
    same pixel are a rectangle. The lines of all polygons are computed together, because a call of NumPy takes as long
    as the computation of some hundred lines.

    polygons: u and v of each corner, (2, corners, n), clockwise in the picture. A polygon with fewer corners repeats
        its last one.
    width, height: the size of the picture in pixels.
    """
    lows, highs = polygons.min(axis=1), polygons.max(axis=1)
    firsts, stops = np.maximum(np.ceil(lows), 0.0), np.minimum(np.floor(highs) + 1.0, ((width,), (height,)))
    counts = np.maximum(stops - firsts, 0.0)
    is_upright = counts[0] < counts[1]
    low, high, first, count = np.where(is_upright, *np.array((lows, highs, firsts, counts)).transpose(1, 0, 2))
    start, length = np.cumsum(count) - count, np.where(is_upright, height, width)
    lines = _Lines(is_upright, length, low, high, first, first + count, start, int(count.sum()))
    bounds = _compute_bounds(np.where(is_upright, polygons[::-1], polygons), lines)
    return list(map(Area, np.concatenate((lows, highs)).T.tolist(), _combine_lines(lines, bounds)))


def _compute_bounds(corners: Array, lines: _Lines) -> NDArray[np.intp]:
    """Return for each line its first pixel, and the pixel after its last one, (2, lines).

    corners: u and v of each corner, (2, corners, n).

    The polygons are clockwise in the picture. So rows end at an edge with growing v. If the lines are columns, u and v
    have changed places, and columns begin at such an edge.
    """
    (u, v), (next_u, next_v) = corners, np.concatenate((corners[:, 1:], corners[:, :1]), axis=1)
    is_growing, growth = v < next_v, next_v - v
    is_level = growth == 0.0
    is_end = is_growing ^ lines.is_upright
    low_v, high_v = np.minimum(v, next_v), np.maximum(v, next_v)
    # An edge crosses the lines from its lower end on, and those below its higher end. The highest edge of a polygon
    # also crosses a line at its higher end.
    first = np.maximum(np.ceil(low_v), 0.0)
    stop = np.where(high_v == lines.high, lines.stop, np.minimum(np.ceil(high_v), lines.stop))
    counts = (np.maximum(stop - first, 0.0) * ~is_level).astype(np.intp)
    edges = np.empty((9, *counts.shape))
    edges[0] = first - (np.cumsum(counts) - counts.ravel()).reshape(counts.shape)
    edges[1], edges[2], edges[3] = np.where(is_growing, u, next_u), low_v, (next_u - u) / (growth + is_level)
    edges[4], edges[5], edges[6] = lines.low + SEAM, lines.high - SEAM, np.where(is_end, SEAM, -SEAM)
    edges[7], edges[8] = lines.length, lines.start - lines.first + lines.total * is_end
    crossings = edges.reshape(9, -1).repeat(counts.ravel(), axis=1)
    offset, low_u, low_v, slope, lowest, highest, seam, length, index = crossings
    line = np.arange(crossings.shape[1]) + offset
    at = slope * (np.minimum(np.maximum(line, lowest), highest) - low_v) + low_u
    # A line that crosses only one edge, by rounding, stays empty.
    bounds = np.zeros(2 * lines.total, np.intp)
    bounds[: lines.total] = lines.length.max(initial=0)
    bounds[(line + index).astype(np.intp)] = np.minimum(np.maximum(np.ceil(at + seam), 0.0), length)
    return bounds.reshape(2, -1)


def _combine_lines(lines: _Lines, bounds: NDArray[np.intp]) -> list[list[list[int]]]:
    """Return the rectangles of each polygon.

    bounds: for each line its first pixel, and the pixel after its last one, (2, lines).
    """
    is_new, start = np.ones(lines.total + 1, np.bool_), lines.start.astype(np.intp)
    is_new[1:-1] = (bounds[:, 1:] != bounds[:, :-1]).any(axis=0)
    is_new[start] = True
    runs = np.flatnonzero(is_new)
    cuts = np.append(runs.searchsorted(start), len(runs) - 1)
    owner = np.arange(len(start)).repeat(cuts[1:] - cuts[:-1])
    across = bounds[:, runs[:-1]]
    along = np.array((runs[:-1], runs[1:])) + (lines.first.astype(np.intp) - start)[owner]
    rectangles = np.where(
        lines.is_upright[owner], np.concatenate((across, along)), np.concatenate((along, across))
    ).T.tolist()
    return [rectangles[begin:end] for begin, end in pairwise(cuts.tolist())]
