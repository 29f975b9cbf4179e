"""Paths over a grid: how far each cell is, and the way there."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

Mask = NDArray[np.bool_]
Steps = NDArray[np.int32]
Cell = tuple[int, int]

UNREACHED = np.iinfo(np.int32).max
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
_SQUARE = cv2.getStructuringElement(cv2.MORPH_RECT, (3, 3))


def steps_from(start: Cell, open_cells: Mask) -> Steps:
    """Return each cell's distance from ``start`` in steps over open cells; UNREACHED where there is no way.

    A wave goes out, by turns over edges and over corners, so that its fronts are octagons.
    """
    steps = np.full(open_cells.shape, UNREACHED, dtype=np.int32)
    passable = open_cells.astype(np.uint8)
    reached = np.zeros_like(passable)
    reached[start] = 1
    steps[start] = 0
    idle = 0
    for step in range(1, open_cells.size):
        grown = reached | (passable & np.asarray(cv2.dilate(reached, _SQUARE if step % 2 else _CROSS), np.uint8))
        new = grown != reached
        idle = 0 if new.any() else idle + 1
        if idle == 2:
            break
        steps[new] = step
        reached = grown
    return steps


def path_back(steps: Steps, goal: Cell) -> list[Cell]:
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
    count = 2 * max(abs(goal[0] - start[0]), abs(goal[1] - start[1])) + 1
    rows = np.linspace(start[0], goal[0], count).round().astype(int)
    columns = np.linspace(start[1], goal[1], count).round().astype(int)
    is_start = (rows == start[0]) & (columns == start[1])
    return bool((open_cells[rows, columns] | is_start).all())
