"""Find the pixels of a convex polygon, as rectangles that NumPy fills.

`cv2.fillConvexPoly` is not exact enough, because it paints half a pixel beyond each edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

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


_Edge = tuple[int, int, float, float, float]
"""An edge of a polygon, and the lines that cross it. They lie along the axis u, and the axis v numbers them.

The numbers are the first line, the line after the last one, the slope, and u and v of the edge's end with the lower v.
u is moved outwards by `SEAM`. A class would take as long as the rest of the work on an edge.
"""


class _Lines(NamedTuple):
    """The lines of the picture on which a polygon lies: rows, or columns if it has fewer of them."""

    is_upright: bool
    """Whether the lines are columns."""
    first: int
    """The first line."""
    stop: int
    """The line after the last one."""
    low: float
    """The v of the polygon's first line, in pixels."""
    high: float
    """The v of the polygon's last line, in pixels."""
    length: int
    """The number of pixels in a line of the picture."""


def rasterize(us: Sequence[float], vs: Sequence[float], width: int, height: int) -> Area:
    """Return the pixels of a convex polygon in a picture.

    A polygon consists of lines: rows, or columns if it has fewer of them. The lines between two corners are a
    trapezoid. All of them cover the pixels in its middle, so that only the pixels at its sides need a mask.

    us, vs: the columns and the rows of the corners in pixels, clockwise in the picture.
    width, height: the size of the picture in pixels.
    """
    left, top, right, bottom = min(us), min(vs), max(us), max(vs)
    column, last_column = max(ceil(left), 0), min(floor(right), width - 1)
    row, last_row = max(ceil(top), 0), min(floor(bottom), height - 1)
    if last_column - column < last_row - row:
        lines = _Lines(True, column, last_column + 1, left + SEAM, right - SEAM, height)
        begins, ends = _list_edges(vs[::-1], us[::-1], lines)  # with exchanged axes, clockwise is the reverse order
    else:
        lines = _Lines(False, row, last_row + 1, top + SEAM, bottom - SEAM, width)
        begins, ends = _list_edges(us, vs, lines)
    pieces: list[Piece] = []
    while begins and ends:
        begin, end = begins[-1], ends[-1]
        first, stop = max(begin[0], end[0]), min(begin[1], end[1])
        if first < stop:  # by rounding, a line may cross only one edge
            pieces += _divide(first, stop, begin, end, lines)
        if begin[1] == stop:
            begins.pop()
        if end[1] == stop:
            ends.pop()
    return Area((left, top, right, bottom), pieces)


def _list_edges(us: Sequence[float], vs: Sequence[float], lines: _Lines) -> tuple[list[_Edge], list[_Edge]]:
    """Return the edges at which lines begin, and those at which they end. In both lists, v falls.

    us, vs: the coordinates of the corners along and across the lines, in pixels, clockwise.
    """
    _, start, end, low, high, _ = lines
    begins: list[_Edge] = []
    ends: list[_Edge] = []
    u, v = us[-1], vs[-1]
    for next_u, next_v in zip(us, vs, strict=True):
        # Lines end at an edge on which v grows, and begin at the others.
        if v < next_v:
            edges, low_u, low_v, high_v = ends, u + SEAM, v, next_v
        else:
            edges, low_u, low_v, high_v = begins, next_u - SEAM, next_v, v
        if low_v <= high and high_v > low and low_v < high_v:
            first = start if low_v <= low else max(ceil(low_v), start)
            stop = end if high_v > high else min(ceil(high_v), end)
            if first < stop:
                edges.append((first, stop, (next_u - u) / (next_v - v), low_u, low_v))
        u, v = next_u, next_v
    begins.sort(reverse=True)
    ends.sort(reverse=True)
    return begins, ends


def _divide(first: int, stop: int, begin: _Edge, end: _Edge, lines: _Lines) -> list[Piece]:
    """Return the pieces of a trapezoid.

    first, stop: the trapezoid's first line, and the line after its last one.
    begin, end: the edges at which its lines begin and end.
    """
    is_upright, _, _, low, high, length = lines
    (_, _, slope, u, v), (_, _, end_slope, end_u, end_v) = begin, end
    lowest, highest = min(max(first, low), high), max(min(stop - 1, high), low)
    begins = slope * (lowest - v) + u, slope * (highest - v) + u
    ends = end_slope * (lowest - end_v) + end_u, end_slope * (highest - end_v) + end_u
    outside, beyond = max(ceil(min(begins)), 0), min(ceil(max(ends)), length)
    inner, outer = max(ceil(max(begins)), outside), min(ceil(min(ends)), beyond)
    along, pieces = slice(first, stop), []
    for left, right in ((outside, inner), (inner, outer), (outer, beyond)) if inner <= outer else ((outside, beyond),):
        if left >= right:
            continue
        is_covered: NDArray[np.bool_] | None = None
        if left < inner or right > outer:
            levels = NUMBERS[along]
            if lowest != first or highest != stop - 1:
                levels = np.minimum(np.maximum(levels, low), high)
            numbers = NUMBERS[left:right]
            if is_upright:
                numbers = numbers[:, None]
            else:
                levels = levels[:, None]
            if left < inner:
                is_covered = numbers >= slope * (levels - v) + u
            if right > outer:
                is_inside = numbers < end_slope * (levels - end_v) + end_u
                is_covered = is_inside if is_covered is None else is_covered & is_inside
        across = slice(left, right)
        pieces.append((((across, along) if is_upright else (along, across)), is_covered))
    return pieces
