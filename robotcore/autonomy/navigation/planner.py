"""Plans paths over the map: traversable cells, straight paths to a target, and the cheapest path to a goal."""

from __future__ import annotations

from enum import Enum
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from robotcore.autonomy.navigation.grid_paths import (
    UNREACHED,
    Cell,
    Mask,
    are_straight_ways,
    backtrack,
    is_straight_way,
    wavefront,
)
from robotcore.autonomy.navigation.occupancy_grid import Metres, OccupancyGrid, Window, get_corner
from robotcore.geometry import Pose

MARGINS_M = (0.08, 0.05, 0.02)
"""The possible clearances between the turning robot and bodies. A path uses the widest one that is possible."""

EXCLUDED_RADIUS_M = 0.2
"""Paths over unknown cells stay this far away from a barred cell. See `Traversability.bar`."""

START_CELLS = 2
"""The robot may use this number of cells on each side of its own cell in any case, to leave a narrow place."""


class Certainty(Enum):
    """The kinds of cells that a path may use. See `OccupancyGrid.uncertain`."""

    KNOWN = "free cells"
    UNKNOWN = "free and unknown cells"
    DOUBTFUL = "free, unknown and uncertain cells"


class GridPath(NamedTuple):
    """A path over the map."""

    cells: list[Cell]
    """The row and the column of each cell, from the robot to the goal."""
    open_cells: Mask
    """The mask of all cells that the robot may use, for short cuts at the path's corners."""


NO_PATH = GridPath([], np.zeros((0, 0), np.bool_))


class Traversability:
    """Finds the cells and the paths on which the robot can turn on the spot.

    grid: the map.
    reach: the radius in metres of the circle that the robot covers when it turns on the spot.
    """

    def __init__(self, grid: OccupancyGrid, reach: float) -> None:
        self.grid = grid
        self.reach = reach
        self._barred = np.zeros_like(grid.evidence, np.bool_)

    def bar(self, cell: Cell) -> None:
        """Exclude the cells within `EXCLUDED_RADIUS_M` of this cell from later paths over unknown cells."""
        self._barred |= self.grid.disc(*self.grid.point_of(*cell), EXCLUDED_RADIUS_M)

    def open_cells(self, here: Cell, trust: Certainty = Certainty.KNOWN) -> list[Mask]:
        """Return for each of `MARGINS_M` the mask of the cells that a robot at the cell ``here`` may use."""
        clearance = self._clearance(trust)
        masks = [np.asarray(clearance > self.reach + margin) for margin in MARGINS_M]
        beside = tuple(slice(max(at - START_CELLS, 0), at + START_CELLS + 1) for at in here)
        for mask in masks:
            mask[beside] |= ~self.grid.occupied[beside]
        return masks

    def find_path(self, here: Cell, goal: Cell) -> GridPath:
        """Return a path over free cells with the widest possible margin, or `NO_PATH` if there is none."""
        goals = np.zeros_like(self._barred)
        goals[goal] = True
        for mask in self.open_cells(here):
            steps = wavefront(here, mask, goals)
            if steps[goal] != UNREACHED:
                return GridPath(backtrack(steps, goal), mask)
        return NO_PATH

    def _clearance(self, trust: Certainty) -> Metres:
        if trust is Certainty.KNOWN:
            return self.grid.clearance()
        overlook = self.grid.uncertain if trust is Certainty.DOUBTFUL else None
        clearance = self.grid.clearance(with_unknown=False, overlook=overlook)
        clearance[self._barred] = 0.0
        return clearance


CORRIDOR_M = 0.24
"""The free width that a straight path needs. Other paths need more, because the robot turns on them."""

CORRIDOR_MARGIN_M = 0.03
"""The additional free width on each side of a planned straight path, because new readings may narrow it."""

KNOWN_M = 0.45
"""The cells of a straight path within this distance of the robot must be known to be free.

So near to the robot, the sensor's cone is narrower than the robot, so the sensor may miss an obstacle.
"""

TARGET_BODY_M = 0.1
"""Cells nearer to a target than its stopping distance minus this length count as cells of the target's body."""

RING_M = (0.05, 0.40)
"""The least and the greatest length of the straight path that follows a planned path.

The robot needs this length to turn to the target and to brake.
"""


class StopPoint(NamedTuple):
    """A point, and the distance from it at which the robot stops.

    >>> from robotcore import Pose
    >>> target = StopPoint(x=1.0, y=0.0, distance=0.3)
    >>> target.gap(Pose(0.0, 0.0, 0.0)), target.bearing(Pose(0.0, 0.0, 0.5))
    (0.7, -0.5)
    """

    x: float
    """The point's x in the odometry's frame, in metres."""
    y: float
    """The point's y in the odometry's frame, in metres."""
    distance: float
    """The stopping distance in metres, from the middle of the robot's axle to the point."""

    def gap(self, pose: Pose) -> float:
        """Return how far a robot at this pose has to drive, in metres. It is negative if the pose is too near."""
        return pose.distance_to(self.x, self.y) - self.distance

    def bearing(self, pose: Pose) -> float:
        """Return the direction of the point from a pose, in radians, positive to the left."""
        return pose.bearing_to(self.x, self.y)


def is_unobstructed(grid: OccupancyGrid, pose: Pose, target: StopPoint) -> bool:
    """Return whether no occupied cell is on the straight path from a pose to a target."""
    here, there = grid.cell_of(pose.x, pose.y), grid.cell_of(target.x, target.y)
    window = grid.find_window([here, there], CORRIDOR_M / 2)
    return is_straight_way(_corridor(grid, target, window), here, there, get_corner(window))


def is_start_known(grid: OccupancyGrid, pose: Pose, target: StopPoint) -> bool:
    """Return whether the first `KNOWN_M` of the straight path to a target are known to be free."""
    part = max(0.0, min(KNOWN_M, target.gap(pose))) / max(target.gap(pose) + target.distance, 1e-6)
    middle = grid.cell_of(pose.x + part * (target.x - pose.x), pose.y + part * (target.y - pose.y))
    here = grid.cell_of(pose.x, pose.y)
    window = grid.find_window([here, middle], CORRIDOR_M / 2)
    clearance = grid.clearance(overlook=_target_body(grid, target), window=window)
    return is_straight_way(clearance > CORRIDOR_M / 2, here, middle, get_corner(window))


def find_straight_starts(grid: OccupancyGrid, target: StopPoint) -> Mask:
    """Return the mask of the cells from which an unobstructed straight path leads to a target.

    The length of the straight path is within `RING_M`, so the cells lie in a ring around the target.
    """
    nearest, farthest = (target.distance + before for before in RING_M)
    ring = grid.disc(target.x, target.y, farthest) & ~grid.disc(target.x, target.y, nearest)
    there = grid.cell_of(target.x, target.y)
    corners = [grid.cell_of(target.x + away, target.y + away) for away in (-farthest, farthest)]
    window = grid.find_window(corners, CORRIDOR_M / 2 + CORRIDOR_MARGIN_M)
    corridor = _corridor(grid, target._replace(distance=nearest), window, CORRIDOR_MARGIN_M)
    ring[ring] = are_straight_ways(corridor, np.argwhere(ring), [there], get_corner(window))
    return ring


def _corridor(grid: OccupancyGrid, target: StopPoint, window: Window, spare: float = 0.0) -> Mask:
    """Return the mask of the cells with room for a straight path, and of the cells of the target's body.

    window: the part of the map that the mask covers.
    spare: the additional free width on each side of the path, in metres.
    """
    itself = _target_body(grid, target)
    clearance = grid.clearance(with_unknown=False, overlook=itself, window=window)
    return np.asarray((clearance > CORRIDOR_M / 2 + spare) | itself[window])


def _target_body(grid: OccupancyGrid, target: StopPoint) -> Mask:
    return grid.disc(target.x, target.y, target.distance - TARGET_BODY_M)


SURCHARGE_M = {Certainty.KNOWN: 0.0, Certainty.UNKNOWN: 0.4, Certainty.DOUBTFUL: 1.2}
"""The additional cost of a path by its cells, in metres.

A path over cells that are not surely free may be blocked, so that the robot drives some metres in vain.
"""

MARGIN_COST_M = 0.3
"""The additional cost of a path, in metres, for each of `MARGINS_M` that is too wide for the path."""

MIN_FREE_PATH_M = 0.3
"""The least length of the free part of a path. At the end of a shorter part, the sensors measure nothing new."""

TRIES = 8
"""The greatest number of candidates that one call of `plan_path` examines."""

UNKNOWN_BEARING_M = 0.32
"""The distance from the start of a path's unknown part to the point whose bearing `compute_unknown_bearing` returns."""


class PathPlan(NamedTuple):
    """A path over free cells, and the cells that follow on the way to the goal but are not surely free."""

    path: GridPath
    unknown_part: list[Cell]

    def compute_unknown_bearing(self, pose: Pose, ground: Traversability) -> float:
        """Return the bearing of the unknown part in radians, or 0 if there is no unknown part."""
        if not self.unknown_part:
            return 0.0
        step = min(len(self.unknown_part) - 1, round(UNKNOWN_BEARING_M / ground.grid.cell))
        return pose.bearing_to(*ground.grid.point_of(*self.unknown_part[step]))


NO_PATH_PLAN = PathPlan(NO_PATH, [])


class _Candidate(NamedTuple):
    cost: float
    path: list[Cell]
    margin: int


def plan_path(ground: Traversability, here: Cell, goals: Mask, *, is_surveyed: bool) -> PathPlan:
    """Return the cheapest path to one of several goals, split into its free and its unknown part.

    Return `NO_PATH_PLAN` if there is no path. If the free part is too short to drive, it is empty in the result: the
    robot should then survey the unknown part from here. After such a survey, the start of the unknown part is barred,
    and the next cheapest path is returned.

    ground: the traversable cells.
    here: the robot's cell.
    goals: the mask of the goals' cells.
    is_surveyed: whether the robot has surveyed its surroundings from here.
    """
    for _ in range(TRIES):
        candidates = [_find_widest_path(ground, here, goals, trust) for trust in Certainty]
        candidate = min(filter(None, candidates), key=lambda candidate: candidate.cost, default=None)
        if candidate is None:
            return NO_PATH_PLAN
        detour = _split_path(ground, candidate)
        if not detour.unknown_part or len(detour.path.cells) * ground.grid.cell > MIN_FREE_PATH_M:
            return detour
        if not is_surveyed:
            return PathPlan(NO_PATH, detour.unknown_part)
        ground.bar(detour.unknown_part[0])
    return NO_PATH_PLAN


def _find_widest_path(ground: Traversability, here: Cell, goals: Mask, trust: Certainty) -> _Candidate | None:
    for margin, mask in enumerate(ground.open_cells(here, trust)):
        steps = wavefront(here, mask, goals)
        at_goals = np.where(goals, steps, UNREACHED)
        goal = divmod(int(at_goals.argmin()), at_goals.shape[1])
        if at_goals[goal] != UNREACHED:
            cost = float(steps[goal]) * ground.grid.cell + SURCHARGE_M[trust] + MARGIN_COST_M * margin
            return _Candidate(cost, backtrack(steps, goal), margin)
    return None


def _split_path(ground: Traversability, candidate: _Candidate) -> PathPlan:
    path = candidate.path
    known_cells = ground.open_cells(path[0])[candidate.margin]
    known = list(takewhile(lambda cell: known_cells[cell], path))
    return PathPlan(GridPath(known, known_cells), path[len(known) :])
