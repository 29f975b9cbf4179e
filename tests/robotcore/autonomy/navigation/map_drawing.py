"""Functions that draw on maps for tests."""

from __future__ import annotations

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.navigation.occupancy_grid import CLOSE_M
from robotcore.geometry import Pose

REACH = 0.17
HERE = Pose(0.0, 0.0, 0.0)


def mark_occupied(
    grid: OccupancyGrid, left: float, right: float, bottom: float, top: float, nearest_echo: float = CLOSE_M / 2
) -> None:
    """Mark a rectangle as occupied, from x ``left`` to ``right`` and from y ``bottom`` to ``top``."""
    (low, first), (high, last) = grid.cell_of(left, bottom), grid.cell_of(right, top)
    grid.evidence[low : high + 1, first : last + 1] = 1.0
    grid.nearest_echo[low : high + 1, first : last + 1] = nearest_echo


def mark_unknown(grid: OccupancyGrid, left: float, right: float, bottom: float, top: float) -> None:
    """Mark a rectangle as unknown, from x ``left`` to ``right`` and from y ``bottom`` to ``top``."""
    (low, first), (high, last) = grid.cell_of(left, bottom), grid.cell_of(right, top)
    grid.evidence[low : high + 1, first : last + 1] = 0.0
