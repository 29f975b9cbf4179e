"""Finds the corners of a chessboard in pictures, and chooses pictures with different positions of the board."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from robotcore.errors import UsageError
from robotcore.optics import Image

Corners = NDArray[np.float32]
"""The corners of a board in a picture: the column and the row of each in pixels, shape (n, 2)."""

MIN_CORNERS, MAX_CORNERS = 3, 30
"""The least and the greatest number of corners in a row or a column of a board."""

MIN_WINDOW_PX, MAX_WINDOW_PX = 2, 11
"""The least and the greatest distance from a corner to the edge of the window in which it is refined, in pixels.

The window is a third of the smallest square, so that it contains no other corner.
"""


@dataclass(frozen=True)
class Board:
    """A chessboard. Its size is the number of inner corners, at which four squares meet.

    >>> board = Board.parse("9x6", 0.025)
    >>> str(board), board.points.shape, board.points[1].tolist()
    ('9x6', (54, 3), [0.02500000037252903, 0.0, 0.0])
    """

    columns: int
    """The number of inner corners in a row."""
    rows: int
    """The number of inner corners in a column."""
    square_m: float = 0.025
    """The side of a square, in metres."""

    @classmethod
    def parse(cls, size: str, square_m: float) -> Board:
        """Return the board with a size such as ``9x6``. Raises UsageError for another text or a wrong number."""
        found = re.fullmatch(r"\s*(\d{1,3})\s*[x×]\s*(\d{1,3})\s*", size)
        numbers = [int(number) for number in found.groups()] if found else []
        if not numbers or not all(MIN_CORNERS <= number <= MAX_CORNERS for number in numbers):
            raise UsageError(
                f"the board {size!r} is no size. Give the numbers of inner corners, each from {MIN_CORNERS} to "
                f"{MAX_CORNERS}, such as --board 9x6 for a board of 10 by 7 squares",
                kind="wrong-board",
            )
        if not 0 < square_m < 10:
            text = f"the side of a square is {square_m:g} m. Give it in metres, such as --square 0.025"
            raise UsageError(text, kind="wrong-square", square_m=square_m)
        return cls(numbers[0], numbers[1], square_m)

    def __str__(self) -> str:
        return f"{self.columns}x{self.rows}"

    @property
    def points(self) -> NDArray[np.float32]:
        """The places of the corners on the board, in metres, shape (n, 3). All z are 0."""
        places = np.zeros((self.columns * self.rows, 3), np.float32)
        places[:, :2] = np.mgrid[0 : self.columns, 0 : self.rows].T.reshape(-1, 2) * self.square_m
        return places

    def find(self, grey: Image) -> Corners | None:
        """Return the corners in a grey picture, row by row; None if the picture does not show the whole board."""
        is_found, corners = cv2.findChessboardCornersSB(grey, (self.columns, self.rows), flags=cv2.CALIB_CB_ACCURACY)
        return self._refine(grey, np.asarray(corners, np.float32).reshape(-1, 2)) if is_found else None

    def _refine(self, grey: Image, corners: Corners) -> Corners:
        """Return corners with an error that is a fifth of that of the finder, measured in rendered pictures."""
        rows = corners.reshape(self.rows, self.columns, 2)
        sides = [np.linalg.norm(np.diff(rows, axis=axis), axis=2).min() for axis in (0, 1)]
        reach = int(min(max(min(sides) / 3, MIN_WINDOW_PX), MAX_WINDOW_PX))
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 40, 0.001)
        refined = cv2.cornerSubPix(grey, corners.reshape(-1, 1, 2), (reach, reach), (-1, -1), criteria)
        return np.asarray(refined, np.float32).reshape(-1, 2)

    def find_other_size(self, pictures: Sequence[Image]) -> Board | None:
        """Return the board of a similar size that most grey pictures show; None if at most one of four shows it.

        Many people count squares in place of inner corners, or leave out a row.
        """
        changes = [(columns, rows) for columns in (0, -1, 1, -2) for rows in (0, -1, 1, -2) if columns or rows]
        sizes = [(self.columns + columns, self.rows + rows) for columns, rows in changes]
        others = [Board(*size, self.square_m) for size in sizes if min(size) >= MIN_CORNERS]
        counts = {other: sum(other.find(picture) is not None for picture in pictures) for other in others}
        best = max(counts, key=lambda other: counts[other])
        return best if 4 * counts[best] > len(pictures) else None


CELLS = 3
"""The picture has this many regions in each row and in each column, which the corners of the boards must reach."""

ROWS, COLUMNS = ("top", "middle", "bottom"), ("left", "centre", "right")

MIN_MOVE = 0.04
"""Two views of a board are different if a corner moves by this share of the picture's width on average."""

MAX_SHAKE_PX = 1.5
"""A board stands still if its corners move by less than this from picture to picture, in pixels."""


class ViewSelection:
    """Selects views of a board that differ from each other, and that together reach all regions of the picture.

    size: the width and the height of the pictures, in pixels.
    """

    def __init__(self, size: tuple[int, int]) -> None:
        self.size = size
        self.views: list[Corners] = []
        self._last: Corners | None = None

    def add(self, corners: Corners) -> bool:
        """Add a view, unless it is nearly equal to one before. Return whether it was added."""
        differences = (_measure_shift(corners, view) for view in self.views)
        if any(difference < MIN_MOVE * self.size[0] for difference in differences):
            return False
        self.views.append(corners)
        return True

    def add_still(self, corners: Corners | None) -> bool:
        """Add the view of a live picture, if the board stands still in it. Return whether it was added.

        corners: the corners in the next picture; None if it does not show the board.
        """
        last, self._last = self._last, corners
        if last is None or corners is None or _measure_shift(corners, last) > MAX_SHAKE_PX:
            return False
        return self.add(corners)

    @property
    def uncovered(self) -> list[str]:
        """The names of the regions that no corner has reached, such as ``top left``."""
        width, height = self.size
        reached = {
            (min(int(v * CELLS / height), CELLS - 1), min(int(u * CELLS / width), CELLS - 1))
            for view in self.views
            for u, v in view.tolist()
        }
        cells = [(row, column) for row in range(CELLS) for column in range(CELLS)]
        return [_name_cell(*cell) for cell in cells if cell not in reached]


def _measure_shift(first: Corners, second: Corners) -> float:
    return float(np.linalg.norm(first - second, axis=1).mean())


def _name_cell(row: int, column: int) -> str:
    if row == column == CELLS // 2:
        return "centre"
    parts = (ROWS[row] if row != CELLS // 2 else "", COLUMNS[column] if column != CELLS // 2 else "")
    return " ".join(filter(None, parts))
