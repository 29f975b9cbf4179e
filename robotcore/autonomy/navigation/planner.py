"""Plans paths over the map: free cells for the robot, straight lines to a target, and the cheapest path to it."""

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
from robotcore.autonomy.navigation.occupancy_grid import Metres, OccupancyGrid
from robotcore.geometry import Pose

MARGINS_M = (0.08, 0.05, 0.02)
"""The possible distances between the turning robot and bodies along a path. The widest that allows a path is used."""

BARRED_M = 0.2
"""The radius of the circle around a dead end that later paths avoid."""

BESIDE = 2
"""The robot may use this number of cells on each side of its own cell, so that it can leave a narrow place."""


class Certainty(Enum):
    """The cells that a path may use."""

    KNOWN = "free cells"
    UNKNOWN = "free and unknown cells"
    DOUBTFUL = "free, unknown and uncertain cells"


class Path(NamedTuple):
    """A path over the map."""

    cells: list[Cell]
    """The row and the column of each cell, from the robot to the goal."""
    open_cells: Mask
    """The cells that the robot may use if it cuts the path's corners."""


NO_PATH = Path([], np.zeros((0, 0), np.bool_))


class Traversability:
    """Finds the cells and the paths on which the robot has room.

    grid: the map.
    reach: the radius of the circle around the axle that the robot needs to turn on the spot, in metres.
    """

    def __init__(self, grid: OccupancyGrid, reach: float) -> None:
        self.grid = grid
        self.reach = reach
        self._barred = np.zeros_like(grid.taken)

    def bar(self, cell: Cell) -> None:
        """Exclude the cells within `BARRED_M` of a cell from paths over unknown cells."""
        self._barred |= self.grid.disc(*self.grid.point_of(*cell), BARRED_M)

    def open_cells(self, here: Cell, trust: Certainty = Certainty.KNOWN) -> list[Mask]:
        """Return a mask for each of `MARGINS_M`: the cells that a robot at the cell ``here`` may use."""
        clearance = self._clearance(trust)
        masks = [np.asarray(clearance > self.reach + margin) for margin in MARGINS_M]
        beside = tuple(slice(max(at - BESIDE, 0), at + BESIDE + 1) for at in here)
        for mask in masks:
            mask[beside] |= ~self.grid.taken[beside]
        return masks

    def find_path(self, here: Cell, goal: Cell) -> Path:
        """Return a path over free cells with the widest possible margin, or `NO_PATH` if there is none."""
        goals = np.zeros_like(self._barred)
        goals[goal] = True
        for mask in self.open_cells(here):
            steps = wavefront(here, mask, goals)
            if steps[goal] != UNREACHED:
                return Path(backtrack(steps, goal), mask)
        return NO_PATH

    def _clearance(self, trust: Certainty) -> Metres:
        if trust is Certainty.KNOWN:
            return self.grid.clearance()
        overlook = self.grid.uncertain if trust is Certainty.DOUBTFUL else None
        clearance = self.grid.clearance(with_unknown=False, overlook=overlook)
        clearance[self._barred] = 0.0
        return clearance


CORRIDOR_M = 0.24
"""The width of a straight path. Other paths are wider, because the robot must be able to turn on them."""

SPARE_M = 0.03
"""The additional free width on each side of a planned straight path. New readings may make the path narrower."""

KNOWN_M = 0.45
"""The first cells of a straight path, up to this distance, must be known to be free.

At such a distance the sensor's cone is narrower than the robot, so the sensor may miss an obstacle.
"""

ITSELF_M = 0.1
"""The target's own cells lie within a circle around it. Its radius is the stop's distance minus this length."""

RING_M = (0.05, 0.40)
"""The least and the greatest distance to the stop at which the robot may change to the straight path.

The robot needs this distance to turn and brake.
"""


class Target(NamedTuple):
    """A point to which the robot drives, and the distance from this point at which the robot stops.

    >>> target = Target(x=1.0, y=0.0, distance=0.3)
    >>> target.gap(Pose(0.0, 0.0, 0.0)), target.bearing(Pose(0.0, 0.0, 0.5))
    (0.7, -0.5)
    """

    x: float
    """In metres."""
    y: float
    """In metres."""
    distance: float
    """The distance in metres between the point and the middle of the robot's axle when the robot stops."""

    def gap(self, pose: Pose) -> float:
        """Return the distance from a pose to the stop, in metres. It is negative if the pose is too near."""
        return pose.distance_to(self.x, self.y) - self.distance

    def bearing(self, pose: Pose) -> float:
        """Return the direction of the target from a pose, in radians, positive to the left."""
        return pose.bearing_to(self.x, self.y)


def is_unobstructed(grid: OccupancyGrid, pose: Pose, target: Target) -> bool:
    """Return whether no occupied cell is on the straight path from a pose to a target."""
    here, there = grid.cell_of(pose.x, pose.y), grid.cell_of(target.x, target.y)
    return is_straight_way(_corridor(grid, target), here, there)


def is_start_known(grid: OccupancyGrid, pose: Pose, target: Target) -> bool:
    """Return whether the first `KNOWN_M` of the straight path to a target are known to be free."""
    part = max(0.0, min(KNOWN_M, target.gap(pose))) / max(target.gap(pose) + target.distance, 1e-6)
    middle = grid.cell_of(pose.x + part * (target.x - pose.x), pose.y + part * (target.y - pose.y))
    clearance = grid.clearance(overlook=_itself(grid, target))
    return is_straight_way(clearance > CORRIDOR_M / 2, grid.cell_of(pose.x, pose.y), middle)


def find_straight_starts(grid: OccupancyGrid, target: Target) -> Mask:
    """Return the mask of the cells from which a free straight path leads to a target.

    The cells lie in a ring around the target, at the distances `RING_M` from the stop.
    """
    nearest, farthest = (target.distance + before for before in RING_M)
    ring = grid.disc(target.x, target.y, farthest) & ~grid.disc(target.x, target.y, nearest)
    corridor = _corridor(grid, target._replace(distance=nearest), SPARE_M)
    ring[ring] = are_straight_ways(corridor, np.argwhere(ring), [grid.cell_of(target.x, target.y)])
    return ring


def _corridor(grid: OccupancyGrid, target: Target, spare: float = 0.0) -> Mask:
    """Return the cells with room for a straight path to a target."""
    itself = _itself(grid, target)
    clearance = grid.clearance(with_unknown=False, overlook=itself)
    return np.asarray((clearance > CORRIDOR_M / 2 + spare) | itself)


def _itself(grid: OccupancyGrid, target: Target) -> Mask:
    return grid.disc(target.x, target.y, target.distance - ITSELF_M)


SURCHARGE_M = {Certainty.KNOWN: 0.0, Certainty.UNKNOWN: 0.4, Certainty.DOUBTFUL: 1.2}
"""The additional cost of a path that may prove blocked, in metres: the length that the robot then drives in vain."""

NARROW_M = 0.3
"""The additional cost of a path, in metres, for each of `MARGINS_M` that is too wide for it."""

WORTH_M = 0.3
"""The least length of a path over free cells. From the end of a shorter path, the sensors measure nothing new."""

TRIES = 8
"""The greatest number of paths that one call of `plan_path` plans."""

AHEAD_M = 0.32
"""The bearing of a path's unknown part is that of its point at this distance from its start."""


class PathPlan(NamedTuple):
    """A path over free cells, and its continuation over cells that are not surely free."""

    path: Path
    unknown_part: list[Cell]

    def bearing_on(self, pose: Pose, ground: Traversability) -> float:
        """Return the bearing of the unknown part in radians, or 0 if there is no unknown part."""
        if not self.unknown_part:
            return 0.0
        step = min(len(self.unknown_part) - 1, round(AHEAD_M / ground.grid.cell))
        return pose.bearing_to(*ground.grid.point_of(*self.unknown_part[step]))


NO_PATH_PLAN = PathPlan(NO_PATH, [])


class _Candidate(NamedTuple):
    cost: float
    path: list[Cell]
    margin: int


def plan_path(ground: Traversability, here: Cell, goals: Mask, *, is_surveyed: bool) -> PathPlan:
    """Return the cheapest path to one of several goals, split into its part over free cells and its unknown part.

    Return `NO_PATH_PLAN` if there is no path. If the part over free cells is too short, it is empty in the result.
    The robot should then survey the unknown part from here. If it has done so, the start of the unknown part is
    barred, and the next cheapest path is planned.

    ground: the traversable cells.
    here: the robot's cell.
    goals: the mask of the goals' cells.
    is_surveyed: whether the robot has surveyed its surroundings from here.
    """
    for _ in range(TRIES):
        candidate = _find_cheapest(ground, here, goals)
        if candidate is None:
            return NO_PATH_PLAN
        detour = _split_path(ground, candidate)
        if not detour.unknown_part or len(detour.path.cells) * ground.grid.cell > WORTH_M:
            return detour
        if not is_surveyed:
            return PathPlan(NO_PATH, detour.unknown_part)
        ground.bar(detour.unknown_part[0])
    return NO_PATH_PLAN


def _find_cheapest(ground: Traversability, here: Cell, goals: Mask) -> _Candidate | None:
    """Return the path with the least cost. The cost is the length plus the surcharges for certainty and margin."""
    candidates = [_find_shortest(ground, here, goals, trust) for trust in Certainty]
    return min(filter(None, candidates), key=lambda candidate: candidate.cost, default=None)


def _find_shortest(ground: Traversability, here: Cell, goals: Mask, trust: Certainty) -> _Candidate | None:
    """Return the shortest path to a goal with the widest possible margin."""
    for margin, mask in enumerate(ground.open_cells(here, trust)):
        steps = wavefront(here, mask, goals)
        at_goals = np.where(goals, steps, UNREACHED)
        goal = divmod(int(at_goals.argmin()), at_goals.shape[1])
        if at_goals[goal] != UNREACHED:
            cost = float(steps[goal]) * ground.grid.cell + SURCHARGE_M[trust] + NARROW_M * margin
            return _Candidate(cost, backtrack(steps, goal), margin)
    return None


def _split_path(ground: Traversability, candidate: _Candidate) -> PathPlan:
    """Split a path at its first cell that is not surely free."""
    path = candidate.path
    known_cells = ground.open_cells(path[0])[candidate.margin]
    known = list(takewhile(lambda cell: known_cells[cell], path))
    return PathPlan(Path(known, known_cells), path[len(known) :])
