"""Shortest ways and lines of sight on a grid of cells."""

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
_SQUARE = cv2.getStructuringElement(cv2.MORPH_RECT, (3, 3))


def wavefront(start: Cell, open_cells: Mask, goals: Mask | None = None) -> Steps:
    """Return each cell's distance from ``start`` in steps over open cells; UNREACHED where there is no way.

    A wave goes out, by turns over edges and over corners, so that its fronts are octagons. It ends where it reaches
    the nearest of ``goals``, if there are any: cells farther off stay unreached.
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
    """Number the cells in the order in which a wave reaches them; ends two steps after it has reached its last."""
    reached = (steps == 0).astype(np.uint8)
    idle = 0
    for step in range(1, steps.size):
        grown = passable & np.asarray(cv2.dilate(reached, _SQUARE if step % 2 else _CROSS), np.uint8)
        new = grown != reached
        idle = 0 if new.any() else idle + 1
        if idle == 2:
            break
        steps[new] = step
        reached = grown
        if goals is not None and goals[new].any():
            break


def backtrack(steps: Steps, goal: Cell) -> list[Cell]:
    """Return the cells from the start of the wave to ``goal``, which it has reached."""
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
    """Return whether all cells on the line between two are open, the first apart."""
    return bool(are_straight_ways(open_cells, [start], [goal])[0])


def are_straight_ways(open_cells: Mask, starts: ArrayLike, goals: ArrayLike) -> Mask:
    """Return whether all cells on the line from each start to its goal are open, the start apart.

    Starts and goals are (n, 2), or (1, 2) for one that all have in common; what lies outside the grid is open.
    """
    first, last = np.broadcast_arrays(np.asarray(starts), np.asarray(goals))
    lines = _lines(first, last)
    inside = np.asarray(((lines >= 0) & (lines < open_cells.shape)).all(axis=2))
    rows, columns = np.where(inside[..., None], lines, 0).transpose(2, 0, 1)
    is_start = (lines == first[:, None]).all(axis=2)
    return np.asarray((open_cells[rows, columns] | is_start | ~inside).all(axis=1))


def _lines(first: NDArray[np.intp], last: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the cells of lines, (n, points, 2): two a step, so that no corner is cut; each repeats its end."""
    spans = 2 * np.abs(last - first).max(axis=1)
    at = np.minimum(np.arange(spans.max(initial=0) + 1), spans[:, None])[..., None]
    pace = (last - first) / np.maximum(spans, 1)[:, None]
    return np.asarray((first[:, None] + at * pace[:, None]).round().astype(np.intp))


Angles = NDArray[np.float64]
Cells = NDArray[np.intp]


class Rays(NamedTuple):
    """The cells that rays pass: arrays of shape (starts, angles, radii).

    Where a ray has left the grid it is not ``inside``; its rows and columns stay at the border there.
    """

    rows: Cells
    columns: Cells
    inside: Mask

    def of(self, mask: Mask) -> Mask:
        """Return what a mask of the grid says along the rays; False outside."""
        return np.asarray(mask[self.rows, self.columns] & self.inside)


def rays_from(starts: Cells, angles: Angles, radii: Cells, count: int) -> Rays:
    """Return the rays from cells, (n, 2), at angles in radians, at radii in cells, over a grid of count × count."""
    rows = starts[:, 0, None, None] + np.rint(np.sin(angles)[:, None] * radii).astype(np.intp)
    columns = starts[:, 1, None, None] + np.rint(np.cos(angles)[:, None] * radii).astype(np.intp)
    inside = (rows >= 0) & (rows < count) & (columns >= 0) & (columns < count)
    return Rays(rows.clip(0, count - 1), columns.clip(0, count - 1), inside)


def hidden(hides: Mask) -> Mask:
    """Return which cells of rays, (…, radii), are hidden: from the first that hides on."""
    return np.asarray(np.logical_or.accumulate(hides, axis=-1))
