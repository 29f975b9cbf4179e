"""Shortest paths and lines of sight on a grid of cells."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

Mask = NDArray[np.bool_]
Steps = NDArray[np.int32]
Cell = tuple[int, int]

UNREACHED = np.iinfo(np.int32).max
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
SQUARE = cv2.getStructuringElement(cv2.MORPH_RECT, (3, 3))
"""A cell and its eight neighbours, for the morphological functions of OpenCV."""


def wavefront(start: Cell, open_cells: Mask, goals: Mask | None = None) -> Steps:
    """Return for each cell the number of steps on the shortest path from the start to this cell.

    A cell to which no path leads has the value `UNREACHED`. The function is a breadth-first search. Odd steps go to all
    eight neighbours of a cell, even steps to the four that share an edge. So the search reaches the cells at the same
    distance from the start at about the same step.

    start: row and column of the start.
    open_cells: the cells that a path may use.
    goals: if given, the search ends at the nearest of these cells, and cells farther away are `UNREACHED`.

    >>> wavefront((0, 0), np.array([[True, True, False, True]]))[0, :2].tolist()
    [0, 1]
    """
    steps = np.full(open_cells.shape, UNREACHED, dtype=np.int32)
    steps[start] = 0
    passable = open_cells.astype(np.uint8)
    passable[start] = 1
    left, top, width, height = cv2.boundingRect(passable)
    inside = slice(top, top + height), slice(left, left + width)
    _flood(steps[inside], passable[inside], None if goals is None else goals[inside])
    return steps


def _flood(steps: Steps, passable: NDArray[np.uint8], goals: Mask | None) -> None:
    """Write into ``steps`` the number of the step that reaches each cell.

    The search ends after two successive steps without a new cell. One is not enough: an even step goes to no diagonal
    neighbour.
    """
    reached = (steps == 0).astype(np.uint8)
    idle = 0
    for step in range(1, steps.size):
        grown = passable & np.asarray(cv2.dilate(reached, SQUARE if step % 2 else _CROSS), np.uint8)
        new = grown != reached
        idle = 0 if new.any() else idle + 1
        if idle == 2:
            break
        steps[new] = step
        reached = grown
        if goals is not None and goals[new].any():
            break


def backtrack(steps: Steps, goal: Cell) -> list[Cell]:
    """Return the cells of a shortest path to a goal, from the result of `wavefront`. The start is the first cell.

    >>> backtrack(wavefront((0, 0), np.ones((1, 3), bool)), (0, 2))
    [(0, 0), (0, 1), (0, 2)]
    """
    path = [goal]
    while steps[path[-1]] > 0:
        row, column = path[-1]
        around = steps[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
        lowest = np.unravel_index(int(around.argmin()), around.shape)
        following = (max(row - 1, 0) + int(lowest[0]), max(column - 1, 0) + int(lowest[1]))
        if following == path[-1]:
            break
        path.append(following)
    return path[::-1]


def is_straight_way(open_cells: Mask, start: Cell, goal: Cell) -> bool:
    """Return whether all cells on the line between two cells are open, except for the start."""
    return bool(are_straight_ways(open_cells, [start], [goal])[0])


def are_straight_ways(open_cells: Mask, starts: ArrayLike, goals: ArrayLike) -> Mask:
    """Return for each pair of a start and a goal whether all cells on the line are open, except for the start, (n,).

    open_cells: the mask of the open cells. Cells outside the grid count as open.
    starts, goals: rows and columns, (n, 2), or (1, 2) for a cell that all lines have in common.
    """
    first, last = np.broadcast_arrays(np.asarray(starts), np.asarray(goals))
    lines = _lines(first, last)
    inside = np.asarray(((lines >= 0) & (lines < open_cells.shape)).all(axis=2))
    rows, columns = np.where(inside[..., None], lines, 0).transpose(2, 0, 1)
    is_start = (lines == first[:, None]).all(axis=2)
    return np.asarray((open_cells[rows, columns] | is_start | ~inside).all(axis=1))


def _lines(first: NDArray[np.intp], last: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the cells on the lines between pairs of cells, (n, points, 2).

    A line has two points for each cell of its length, so that it skips no cell at a corner. The last cell of a shorter
    line is repeated, because all rows of the array have the same length.
    """
    spans = 2 * np.abs(last - first).max(axis=1)
    at = np.minimum(np.arange(spans.max(initial=0) + 1), spans[:, None])[..., None]
    pace = (last - first) / np.maximum(spans, 1)[:, None]
    return np.asarray((first[:, None] + at * pace[:, None]).round().astype(np.intp))


Angles = NDArray[np.float64]
Cells = NDArray[np.intp]


class Rays(NamedTuple):
    """The cells along rays, in arrays of the shape (number of starts, number of angles, number of radii)."""

    rows: Cells
    """The row of each cell. The rows outside the grid are clipped to its border."""
    columns: Cells
    """The column of each cell. The columns outside the grid are clipped to its border."""
    inside: Mask
    """Whether the cell was inside the grid before it was clipped."""

    def of(self, mask: Mask) -> Mask:
        """Return the value of a mask at each cell along the rays. Outside the grid the value is False."""
        return np.asarray(mask[self.rows, self.columns] & self.inside)


def rays_from(starts: Cells, angles: Angles, radii: Cells, count: int) -> Rays:
    """Return the cells along rays.

    starts: rows and columns, (n, 2).
    angles: the directions of the rays in radians. The column grows in the direction 0, the row in the direction π/2.
    radii: the distances of a ray's cells from its start, in cells.
    count: the number of rows of the grid, which is also that of its columns.
    """
    rows = starts[:, 0, None, None] + np.rint(np.sin(angles)[:, None] * radii).astype(np.intp)
    columns = starts[:, 1, None, None] + np.rint(np.cos(angles)[:, None] * radii).astype(np.intp)
    inside = (rows >= 0) & (rows < count) & (columns >= 0) & (columns < count)
    return Rays(rows.clip(0, count - 1), columns.clip(0, count - 1), inside)


def mask_hidden(hides: Mask) -> Mask:
    """Return for each cell along rays whether it is the ray's first opaque cell or lies behind that cell.

    hides: whether a cell is opaque. The last axis goes along the ray.

    >>> mask_hidden(np.array([False, True, False])).tolist()
    [False, True, True]
    """
    return np.asarray(np.logical_or.accumulate(hides, axis=-1))
