"""Maps as they might have been learnt."""

from __future__ import annotations

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.navigation.occupancy_grid import CLOSE_M
from robotcore.geometry import Pose

REACH = 0.17
HERE = Pose(0.0, 0.0, 0.0)


def take(
    grid: OccupancyGrid, left: float, right: float, bottom: float, top: float, heard_from: float = CLOSE_M / 2
) -> None:
    """Put something that is taken into a map, from x ``left`` to ``right``, from y ``bottom`` to ``top``."""
    (low, first), (high, last) = grid.cell_of(left, bottom), grid.cell_of(right, top)
    grid.evidence[low : high + 1, first : last + 1] = 1.0
    grid.heard_from[low : high + 1, first : last + 1] = heard_from


def veil(grid: OccupancyGrid, left: float, right: float, bottom: float, top: float) -> None:
    """Make part of a map unknown."""
    (low, first), (high, last) = grid.cell_of(left, bottom), grid.cell_of(right, top)
    grid.evidence[low : high + 1, first : last + 1] = 0.0
