"""Paths over the map: what is traversable, how far a target is free, and the cheapest way to it."""

from __future__ import annotations

from enum import Enum
from itertools import takewhile
from typing import NamedTuple

import numpy as np

from robotcore.autonomy.navigation.grid_search import (
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
"""How much more than its own reach the robot keeps from things; the next where the one before leaves no way."""

BARRED_M = 0.2
"""The radius of what is not tried again, round a place where no way opened."""

BESIDE = 2
"""Cells round its own that the robot may step on, however narrow it is there, to get out."""


class Certainty(Enum):
    """What a way may lead over."""

    KNOWN = "what is known to be free"
    UNKNOWN = "the unknown too"
    DOUBTFUL = "the unknown, and what was only heard from afar"


class Path(NamedTuple):
    """Cells one after the other, and the cells over which the robot may cut it short."""

    path: list[Cell]
    open_cells: Mask


NO_PATH = Path([], np.zeros((0, 0), np.bool_))


class Traversability:
    """Where a robot fits that needs ``reach`` metres round its axle to turn on the spot."""

    def __init__(self, grid: OccupancyGrid, reach: float) -> None:
        self.grid = grid
        self.reach = reach
        self._barred = np.zeros_like(grid.taken)

    def bar(self, cell: Cell) -> None:
        """Lead no way that is not known through what lies about a cell."""
        self._barred |= self.grid.disc(*self.grid.point_of(*cell), BARRED_M)

    def open_cells(self, here: Cell, trust: Certainty = Certainty.KNOWN) -> list[Mask]:
        """Return for each of MARGINS_M on which cells a robot that stands ``here`` may go."""
        clearance = self._clearance(trust)
        masks = [np.asarray(clearance > self.reach + margin) for margin in MARGINS_M]
        beside = tuple(slice(max(at - BESIDE, 0), at + BESIDE + 1) for at in here)
        for mask in masks:
            mask[beside] |= ~self.grid.taken[beside]
        return masks

    def way_to(self, here: Cell, goal: Cell) -> Path:
        """Return a way over what is known, with the widest margin that there is; NO_PATH where there is none."""
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
        overlook = self.grid.doubtful if trust is Certainty.DOUBTFUL else None
        clearance = self.grid.clearance(with_unknown=False, overlook=overlook)
        clearance[self._barred] = 0.0
        return clearance


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


SURCHARGE_M = {Certainty.KNOWN: 0.0, Certainty.UNKNOWN: 0.4, Certainty.DOUBTFUL: 1.2}
"""How much longer a way counts for what it leads over: so much may be lost where it does not open."""

NARROW_M = 0.3
"""How much longer a way counts for each margin that is too wide for it."""

WORTH_M = 0.3
"""The known part of a way must be longer than this, for the robot to learn more at its end than it knows here."""

TRIES = 8
"""How many ways are tried, of which all before the last have been barred."""

AHEAD_M = 0.32
"""How far on a way points to where it leads."""


class PathPlan(NamedTuple):
    """A way as far as it is known, and how it goes on ``beyond`` that."""

    way: Path
    beyond: list[Cell]

    def bearing_on(self, pose: Pose, ground: Traversability) -> float:
        """Return in which direction the way goes on beyond what is known; straight ahead where it does not."""
        if not self.beyond:
            return 0.0
        step = min(len(self.beyond) - 1, round(AHEAD_M / ground.grid.cell))
        return pose.bearing_to(*ground.grid.point_of(*self.beyond[step]))


NO_PATH_PLAN = PathPlan(NO_PATH, [])


class _Candidate(NamedTuple):
    cost: float
    path: list[Cell]
    margin: int


def plan_path(ground: Traversability, here: Cell, goals: Mask, *, is_surveyed: bool) -> PathPlan:
    """Return the cheapest way to one of ``goals``, as far as it is known; NO_PATH_PLAN where there is none.

    A way of which too little is known is empty: what is ``beyond`` is to be surveyed from here. Where that
    ``is_surveyed`` and did not come to be known, it is barred, and the next cheapest way is tried.
    """
    for _ in range(TRIES):
        candidate = _cheapest(ground, here, goals)
        if candidate is None:
            return NO_PATH_PLAN
        detour = _known_part(ground, candidate)
        if not detour.beyond or len(detour.way.path) * ground.grid.cell > WORTH_M:
            return detour
        if not is_surveyed:
            return PathPlan(NO_PATH, detour.beyond)
        ground.bar(detour.beyond[0])
    return NO_PATH_PLAN


def _cheapest(ground: Traversability, here: Cell, goals: Mask) -> _Candidate | None:
    """Return the cheapest way to a goal: for its length, for what it leads over, and for how narrow it is."""
    candidates = [_shortest(ground, here, goals, trust) for trust in Certainty]
    return min(filter(None, candidates), key=lambda candidate: candidate.cost, default=None)


def _shortest(ground: Traversability, here: Cell, goals: Mask, trust: Certainty) -> _Candidate | None:
    """Return the shortest way to a goal, with the widest margin that leaves one."""
    for margin, mask in enumerate(ground.open_cells(here, trust)):
        steps = wavefront(here, mask, goals)
        at_goals = np.where(goals, steps, UNREACHED)
        goal = divmod(int(at_goals.argmin()), at_goals.shape[1])
        if at_goals[goal] != UNREACHED:
            cost = float(steps[goal]) * ground.grid.cell + SURCHARGE_M[trust] + NARROW_M * margin
            return _Candidate(cost, backtrack(steps, goal), margin)
    return None


def _known_part(ground: Traversability, candidate: _Candidate) -> PathPlan:
    """Return a way, parted where it leaves what is known to be free."""
    path = candidate.path
    known_cells = ground.open_cells(path[0])[candidate.margin]
    known = list(takewhile(lambda cell: known_cells[cell], path))
    return PathPlan(Path(known, known_cells), path[len(known) :])
