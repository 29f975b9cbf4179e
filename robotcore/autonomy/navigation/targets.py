"""A target that stands out of the map, and the straight ways to it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robotcore.autonomy.navigation.grid import OccupancyGrid
from robotcore.autonomy.navigation.paths import Mask, are_straight_ways, is_straight_way
from robotcore.geometry import Pose

CORRIDOR_M = 0.24
"""How wide a straight way must be: less than a way round, for the robot need not turn on it."""

SPARE_M = 0.03
"""How much wider it must be on either side where it is planned, so that it is still there on arrival."""

KNOWN_M = 0.45
"""How much of its beginning must be known to be free: there the range sensor's cone is narrower than the robot."""

ITSELF_M = 0.1
"""What is nearer to the target, by this, than the robot comes is the target itself."""

RING_M = (0.05, 0.40)
"""How far before its place the robot goes over to the straight way: room enough to turn, and to slow down."""


class Target(NamedTuple):
    """A point to drive at, and at what ``distance`` from it the robot's axle is to come to rest; metres."""

    x: float
    y: float
    distance: float

    def gap(self, pose: Pose) -> float:
        """Return how far there is still to go, in metres; below 0 where the robot is too near."""
        return pose.distance_to(self.x, self.y) - self.distance

    def bearing(self, pose: Pose) -> float:
        """Return the direction of the target as seen from a pose."""
        return pose.bearing_to(self.x, self.y)


def is_unobstructed(grid: OccupancyGrid, pose: Pose, target: Target) -> bool:
    """Return whether nothing is known to be in the straight way to a target."""
    here, there = grid.cell_of(pose.x, pose.y), grid.cell_of(target.x, target.y)
    return is_straight_way(_corridor(grid, target), here, there)


def begins_known(grid: OccupancyGrid, pose: Pose, target: Target) -> bool:
    """Return whether the straight way to a target is known to be free where it begins."""
    part = max(0.0, min(KNOWN_M, target.gap(pose))) / max(target.gap(pose) + target.distance, 1e-6)
    middle = grid.cell_of(pose.x + part * (target.x - pose.x), pose.y + part * (target.y - pose.y))
    clearance = grid.clearance(overlook=_itself(grid, target))
    return is_straight_way(clearance > CORRIDOR_M / 2, grid.cell_of(pose.x, pose.y), middle)


def straight_starts(grid: OccupancyGrid, target: Target) -> Mask:
    """Return from which cells of a ring round a target the way on to it is straight."""
    nearest, farthest = (target.distance + before for before in RING_M)
    ring = grid.disc(target.x, target.y, farthest) & ~grid.disc(target.x, target.y, nearest)
    corridor = _corridor(grid, target._replace(distance=nearest), SPARE_M)
    ring[ring] = are_straight_ways(corridor, np.argwhere(ring), [grid.cell_of(target.x, target.y)])
    return ring


def _corridor(grid: OccupancyGrid, target: Target, spare: float = 0.0) -> Mask:
    """Return where nothing is known to be that narrows a straight way to a target."""
    itself = _itself(grid, target)
    clearance = grid.clearance(with_unknown=False, overlook=itself)
    return np.asarray((clearance > CORRIDOR_M / 2 + spare) | itself)


def _itself(grid: OccupancyGrid, target: Target) -> Mask:
    return grid.disc(target.x, target.y, target.distance - ITSELF_M)
