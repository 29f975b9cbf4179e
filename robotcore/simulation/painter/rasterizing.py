"""Find the pixels of a convex polygon, as rectangles that NumPy fills.

`cv2.fillConvexPoly` is not exact enough, because it paints half a pixel beyond each edge.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.simulation.painter.planes import Array

SEAM = 1e-6
"""The overlap of neighbouring polygons in pixels, so that rounding leaves no gap between them.

A polygon's first and last line move inwards by the same distance. Then each line crosses an edge on both sides.
"""

NUMBERS = np.arange(2.0**14)
"""The numbers of rows and columns. A slice of this array is faster than a new array."""


Piece = tuple[tuple[slice, slice], NDArray[np.bool_] | None]
"""A rectangle of a picture, and whether a polygon covers each of its pixels. None: it covers all of them."""


class Area(NamedTuple):
    """The pixels of a polygon in a picture."""

    box: tuple[float, float, float, float]
    """The left, top, right and bottom edge of the polygon's bounding box, in pixels."""
    pieces: list[Piece]
    """Rectangles that together contain the polygon. They do not overlap."""

    def fill(self, canvas: NDArray[Any], value: int) -> None:
        """Write a value to all pixels."""
        for window, is_covered in self.pieces:
            if is_covered is None:
                canvas[window] = value
            else:
                np.copyto(canvas[window], value, where=is_covered)


class _Edge(NamedTuple):
    """An edge of a polygon, and the lines that cross it. They lie along the axis u, and the axis v numbers them."""

    first: int
    """The first line."""
    stop: int
    """The line after the last one."""
    slope: float
    low_u: float
    """The u of the end with the lower v, in pixels."""
    low_v: float
    seam: float

    def cross(self, levels: Array) -> tuple[Array | float, float, float]:
        """Return the u at which each line crosses the edge, (n,), or one for all lines. Then return its limits.

        levels: the v of the lines, (n,).
        """
        if not self.slope:
            return self.low_u + self.seam, self.low_u + self.seam, self.low_u + self.seam
        u = self.slope * (levels - self.low_v) + self.low_u + self.seam
        first, last = u.item(0), u.item(-1)
        return (u, first, last) if self.slope > 0 else (u, last, first)


def rasterize(us: Sequence[float], vs: Sequence[float], width: int, height: int) -> Area:
    """Return the pixels of a convex polygon in a picture.

    A polygon consists of lines: rows, or columns if it has fewer of them. The lines between two corners are a
    trapezoid. All of them cover the pixels in its middle, so that only the pixels at its sides need a mask.

    us, vs: the columns and the rows of the corners in pixels, clockwise in the picture.
    width, height: the size of the picture in pixels.
    """
    left, top, right, bottom = box = min(us), min(vs), max(us), max(vs)
    columns, rows = _to_pixel_range(left, right, width), _to_pixel_range(top, bottom, height)
    is_upright = len(columns) < len(rows)
    if is_upright:  # with exchanged axes, the corners are clockwise in reverse order
        lines, length, low, high = columns, height, left + SEAM, right - SEAM
        begins, ends = _list_edges(vs[::-1], us[::-1], lines, low, high)
    else:
        lines, length, low, high = rows, width, top + SEAM, bottom - SEAM
        begins, ends = _list_edges(us, vs, lines, low, high)
    pieces: list[Piece] = []
    while begins and ends:
        begin, end = begins[-1], ends[-1]
        first, stop = max(begin.first, end.first), min(begin.stop, end.stop)
        levels = NUMBERS[first:stop]
        if first < low or stop - 1 > high:
            levels = np.minimum(np.maximum(levels, low), high)
        if first < stop:  # by rounding, a line may cross only one edge
            pieces += _divide(slice(first, stop), begin.cross(levels), end.cross(levels), length, is_upright)
        if begin.stop == stop:
            begins.pop()
        if end.stop == stop:
            ends.pop()
    return Area(box, pieces)


def _to_pixel_range(low: float, high: float, size: int) -> range:
    return range(max(math.ceil(low), 0), min(math.floor(high), size - 1) + 1)


def _list_edges(
    us: Sequence[float], vs: Sequence[float], lines: range, low: float, high: float
) -> tuple[list[_Edge], list[_Edge]]:
    """Return the edges at which lines begin, and those at which they end. In both lists, v falls.

    us, vs: the coordinates of the corners along and across the lines, in pixels, clockwise.
    low, high: the v of the polygon's first and last line.
    """
    begins: list[_Edge] = []
    ends: list[_Edge] = []
    u, v = us[-1], vs[-1]
    for next_u, next_v in zip(us, vs, strict=True):
        # Lines end at an edge on which v grows, and begin at the others.
        if v < next_v:
            edges, seam, low_u, low_v, high_v = ends, SEAM, u, v, next_v
        else:
            edges, seam, low_u, low_v, high_v = begins, -SEAM, next_u, next_v, v
        if low_v <= high and high_v > low and low_v < high_v:
            first = lines.start if low_v <= low else max(math.ceil(low_v), lines.start)
            stop = lines.stop if high_v > high else min(math.ceil(high_v), lines.stop)
            if first < stop:
                edges.append(_Edge(first, stop, (next_u - u) / (next_v - v), low_u, low_v, seam))
        u, v = next_u, next_v
    begins.sort(reverse=True)
    ends.sort(reverse=True)
    return begins, ends


def _divide(
    lines: slice,
    begins: tuple[Array | float, float, float],
    ends: tuple[Array | float, float, float],
    length: int,
    is_upright: bool,
) -> Iterator[Piece]:
    """Yield the pieces of a trapezoid.

    begins, ends: the results of `_Edge.cross` on both sides.
    length: the number of pixels in a line of the picture.
    is_upright: whether the lines are columns.
    """
    (begin, least_begin, greatest_begin), (end, least_end, greatest_end) = begins, ends
    first, stop = max(math.ceil(least_begin), 0), min(math.ceil(greatest_end), length)
    inner, outer = max(math.ceil(greatest_begin), first), min(math.ceil(least_end), stop)
    for low, high in ((first, inner), (inner, outer), (outer, stop)) if inner <= outer else ((first, stop),):
        if low >= high:
            continue
        is_covered: NDArray[np.bool_] | None = None
        numbers = NUMBERS[low:high, None] if is_upright else NUMBERS[low:high]
        if low < inner:
            is_covered = numbers >= (begin if is_upright or isinstance(begin, float) else begin[:, None])
        if high > outer:
            is_inside = numbers < (end if is_upright or isinstance(end, float) else end[:, None])
            is_covered = is_inside if is_covered is None else is_covered & is_inside
        yield ((slice(low, high), lines) if is_upright else (lines, slice(low, high))), is_covered
