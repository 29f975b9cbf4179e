"""Shortest paths and lines of sight on a grid of cells."""

from __future__ import annotations

from typing import Any, TypeVar

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

Mask = NDArray[np.bool_]
Steps = NDArray[np.int32]
Cell = tuple[int, int]
Scalar = TypeVar("Scalar", bound=np.generic)

UNREACHED = np.iinfo(np.int32).max
NEAR_CELLS = 48
"""`wavefront` first searches up to this distance from the start, in cells."""

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
    passable = open_cells.copy()
    passable[start] = True
    if goals is not None:
        # Most goals are near. In a square, the search is faster, and paths up to its sides are the same as on the grid.
        top, left = (max(at - NEAR_CELLS, 0) for at in start)
        near = slice(top, start[0] + NEAR_CELLS + 1), slice(left, start[1] + NEAR_CELLS + 1)
        found = _flood((start[0] - top, start[1] - left), passable[near], goals[near])
        if 0 < found[goals[near]].min(initial=UNREACHED) <= NEAR_CELLS:
            steps[near] = found
            return steps
    left, top, width, height = cv2.boundingRect(passable.view(np.uint8))
    inside = slice(top, top + height), slice(left, left + width)
    local = start[0] - top, start[1] - left
    steps[inside] = _flood(local, passable[inside], None if goals is None else goals[inside])
    return steps


def _flood(start: Cell, passable: Mask, goals: Mask | None) -> Steps:
    """Return the number of the step that reaches each cell.

    A mask is one long integer with a bit for each cell, because an integer shifts and combines all its bits at once.

    The search ends after two successive steps without a new cell. One is not enough: an even step goes to no diagonal
    neighbour.
    """
    (row, column), width = start, passable.shape[1]
    line = width + 1  # A closed cell follows each row, so that a shifted bit does not enter the next row.
    open_bits, goal_bits = _pack_bits(passable), 0 if goals is None else _pack_bits(goals)
    reached = 1 << row * line + column
    digits: list[int] = []  # the binary digits of the cells' numbers of steps, as masks, the lowest digit first
    idle = step = 0
    while idle < 2:
        step += 1
        beside = reached | reached << 1 | reached >> 1
        above_and_below = beside if step % 2 else reached
        grown = (beside | above_and_below << line | above_and_below >> line) & open_bits
        new, reached = grown ^ reached, grown
        idle = 0 if new else idle + 1
        if step >> len(digits):
            digits.append(0)
        digits = [digit | new if step >> place & 1 else digit for place, digit in enumerate(digits)]
        if new & goal_bits:
            break
    steps = np.where(_unpack_bits(reached, passable.shape), 0, UNREACHED)
    for place, digit in enumerate(digits):
        steps += _unpack_bits(digit, passable.shape).astype(np.int32) << place
    return steps


def _pack_bits(mask: Mask) -> int:
    """Return a mask as an integer. Its bits are the cells row by row, and a 0 after each row."""
    rows = np.zeros((mask.shape[0], mask.shape[1] + 1), np.bool_)
    rows[:, :-1] = mask
    return int.from_bytes(np.packbits(rows, bitorder="little").tobytes(), "little")


def _unpack_bits(bits: int, shape: tuple[int, ...]) -> Mask:
    """Return the mask of a shape for which `_pack_bits` returns this integer."""
    height, line = shape[0], shape[1] + 1
    data = np.frombuffer(bits.to_bytes(height * line // 8 + 1, "little"), np.uint8)
    return np.unpackbits(data, count=height * line, bitorder="little").reshape(height, line)[:, :-1].view(np.bool_)


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


def is_straight_way(open_cells: Mask, start: Cell, goal: Cell, corner: Cell = (0, 0)) -> bool:
    """Return whether all cells on the line between two cells are open, except for the start.

    It gives the result of `are_straight_ways`, and is faster for one line.
    """
    (row, column), (top, left), (height, width) = start, corner, open_cells.shape
    down, right = goal[0] - row, goal[1] - column
    span = max(2 * max(abs(down), abs(right)), 1)
    step_down, step_right = down / span, right / span
    for at in range(1, span + 1):
        y, x = round(row + at * step_down), round(column + at * step_right)
        is_inside = 0 <= y - top < height and 0 <= x - left < width
        if is_inside and not open_cells[y - top, x - left] and (y, x) != start:
            return False
    return True


def are_straight_ways(open_cells: Mask, starts: ArrayLike, goals: ArrayLike, corner: Cell = (0, 0)) -> Mask:
    """Return for each pair of a start and a goal whether all cells on the line are open, except for the start, (n,).

    open_cells: the mask of the open cells. Cells outside the mask count as open.
    starts, goals: rows and columns, (n, 2), or (1, 2) for a cell that all lines have in common.
    corner: the row and the column of the mask's first cell, if the mask is a part of the grid.
    """
    first, last = np.broadcast_arrays(np.asarray(starts), np.asarray(goals))
    # A line has two points for each cell of its length, so that it skips no cell at a corner. All lines have the same
    # number of points, so the last point of a shorter line is repeated.
    spans = 2 * np.abs(last - first).max(axis=1, keepdims=True)
    at = np.minimum(np.arange(spans.max(initial=0) + 1), spans)
    pace = (last - first) / np.maximum(spans, 1)
    rows, columns = (
        np.rint(begin[:, None] + at * step[:, None]).astype(np.intp)
        for begin, step in zip(first.T, pace.T, strict=True)
    )
    is_start = (rows == first[:, :1]) & (columns == first[:, 1:])
    bordered = np.pad(open_cells, 1, constant_values=True)  # an open border stands for all cells outside the mask
    (top, left), (height, width) = corner, open_cells.shape
    is_open = bordered[(rows - top).clip(-1, height) + 1, (columns - left).clip(-1, width) + 1]
    return np.asarray((is_open | is_start).all(axis=1))


Angles = NDArray[np.float64]
Cells = NDArray[np.intp]


class Rays:
    """The cells along rays, relative to the rays' start.

    rows, columns: the rows and the columns of the cells as whole floats, (angles, radii).
    """

    def __init__(self, rows: NDArray[np.float64], columns: NDArray[np.float64]) -> None:
        self.rows, self.columns = rows, columns
        self._width, self._index = 0, np.empty(0, np.intp)

    def index(self, width: int) -> Cells:
        """Return the cells' indices in a flattened grid with ``width`` columns, relative to that of the start."""
        if width != self._width:
            self._width, self._index = width, (self.rows * width + self.columns).astype(np.intp)
        return self._index

    def lie_within(self, top: int, left: int, size: int) -> Mask:
        """Return whether each cell lies in a square of cells.

        top, left: the row and the column of the square's first cell, relative to the rays' start.
        size: the number of rows and of columns of the square.
        """
        is_in_rows = (self.rows >= top) & (self.rows < top + size)
        return np.asarray(is_in_rows & (self.columns >= left) & (self.columns < left + size))


def compute_rays(angles: Angles, radii: Cells) -> Rays:
    """Return the cells along rays.

    angles: the directions of the rays in radians. The column grows in the direction 0, the row in the direction π/2.
    radii: the distances of a ray's cells from its start, in cells.
    """
    return Rays(np.rint(np.sin(angles)[:, None] * radii), np.rint(np.cos(angles)[:, None] * radii))


def cut_out(array: NDArray[Scalar], low: Cell, high: Cell) -> NDArray[Scalar]:
    """Return the rectangle of an array from one cell to another, both included. Call `set_outside` on what follows.

    In the cells outside the array, the rectangle repeats the border of the array.
    """
    (top, left), (bottom, right), (height, width) = low, high, array.shape
    if top >= 0 and left >= 0 and bottom < height and right < width:
        return array[top : bottom + 1, left : right + 1]
    rows, columns = (np.arange(first, last + 1) for first, last in zip(low, high, strict=True))
    return array.take(rows, axis=0, mode="clip").take(columns, axis=1, mode="clip")


def set_outside(rectangle: NDArray[Any], low: Cell, shape: tuple[int, ...], value: float) -> None:
    """Write a value into all cells of a rectangle that are outside a grid.

    low: the row and the column of the rectangle's first cell on the grid.
    shape: the numbers of rows and columns of the grid.
    """
    (top, left), (height, width) = low, shape
    rectangle[: max(-top, 0)] = rectangle[max(height - top, 0) :] = value
    rectangle[:, : max(-left, 0)] = rectangle[:, max(width - left, 0) :] = value


def mask_hidden(hides: Mask) -> Mask:
    """Return for each cell along rays whether it is the ray's first opaque cell or lies behind that cell.

    hides: whether a cell is opaque. The last axis goes along the ray.

    >>> mask_hidden(np.array([False, True, False])).tolist()
    [False, True, True]
    """
    return np.asarray(np.logical_or.accumulate(hides, axis=-1))
