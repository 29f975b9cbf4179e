"""How the robot moves: along a path, and round itself to look."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from robotcore.autonomy.navigation.grid_search import Angles, Cell, are_straight_ways
from robotcore.autonomy.navigation.planner import NO_PATH, Path, Traversability
from robotcore.geometry import Pose, Twist, wrap_angle

LOOKAHEAD_M = 0.5
"""How far ahead the robot looks for the place to drive at: farther cuts more corners."""

ARRIVED_M = 0.05
"""A place that is nearer than this has been reached: about a cell."""

TURN_FIRST_RAD = 0.4
"""What is farther aside than this is turned to on the spot: an arc to it would swing wide."""

AIMED_RAD = 0.3
"""A target that is farther aside than this is turned to on the spot."""

TURN_GAIN = 2.5
"""How fast to turn for each radian aside, in 1/s."""

SLOWDOWN = 1.5
"""How fast to approach a target for each metre to go, in 1/s."""

BACK_M_S = 0.05
"""How fast to back off, where nothing looks."""

SLOWEST = 0.3
"""The part of its speed that the robot keeps to the end of a way."""

BRAKING_M = 0.3
"""Over how much of its way the robot sheds all of its speed."""


class Steering:
    """Turns bearings into velocities: ``speed`` in m/s and ``turn`` in rad/s at most."""

    def __init__(self, speed: float, turn: float) -> None:
        self.speed = speed
        self.turn = turn

    def turn_to(self, bearing: float) -> float:
        """Return how fast to turn towards a bearing, in rad/s."""
        return max(-self.turn, min(self.turn, TURN_GAIN * bearing))

    def along(self, bearing: float, away: float) -> Twist:
        """Return how to move to a place of a way that is ``away`` metres off."""
        if abs(bearing) > TURN_FIRST_RAD:
            return Twist(0.0, self.turn_to(bearing))
        speed = self.speed * min(1.0, SLOWEST + away / BRAKING_M)
        return Twist(speed * math.cos(bearing), self.turn_to(bearing))

    def approach(self, bearing: float, gap: float) -> Twist:
        """Return how to close a gap of so many metres before a target; backwards where it is below 0."""
        speed = min(self.speed, SLOWDOWN * gap) if abs(bearing) < AIMED_RAD else 0.0
        return Twist(max(speed, -BACK_M_S), self.turn_to(bearing))


class Follower:
    """Follows a way: drives at the farthest place of it, within LOOKAHEAD_M, to which it can be cut short.

    Pure pursuit: Coulter, Implementation of the pure pursuit path tracking algorithm, 1992.
    """

    def __init__(self, ground: Traversability, steering: Steering) -> None:
        self._ground = ground
        self._steering = steering
        self.start(NO_PATH)

    def start(self, way: Path) -> None:
        """Follow this way from now on."""
        self._path, self._open = way

    def follow(self, pose: Pose) -> Twist | None:
        """Return how to move along the way, made anew where something has come up; None where it is at its end."""
        grid = self._ground.grid
        here = grid.cell_of(pose.x, pose.y)
        if any(grid.evidence[cell] > 0 for cell in self._path):
            self.start(self._ground.way_to(here, self._path[-1]))
        while self._path:
            x, y = grid.point_of(*self._carrot(here))
            if (away := pose.distance_to(x, y)) >= ARRIVED_M:
                return self._steering.along(pose.bearing_to(x, y), away)
            self._path.pop(0)
        return None

    def _carrot(self, here: Cell) -> Cell:
        """Return the farthest place of the way, within LOOKAHEAD_M, to which it is straight; forget those before."""
        limit = round(LOOKAHEAD_M / self._ground.grid.cell)
        ahead = self._path[: 2 * limit]
        straight = are_straight_ways(self._open, [here], ahead)
        near = [index for index, cell in enumerate(ahead) if straight[index] and math.dist(here, cell) <= limit]
        self._path = self._path[max(near, default=0) :]
        return self._path[0]


TURNED_RAD = 0.1
"""A heading that is nearer than this has been turned to."""

AHEAD_RAD = 0.8
"""How far a sweep turns to either side of what is ahead."""


class ScanTurn:
    """A turn in one sense, at most once round, past bearings that are worth looking at."""

    def __init__(self, heading: float) -> None:
        self._heading = heading
        self._turned = 0.0
        self._sense = 0.0

    def sense(self, heading: float, bearings: Angles) -> float:
        """Return 1 to go on to the left, -1 to the right, 0 where no bearing is left. Call it once a tick."""
        self._turned += abs(wrap_angle(heading - self._heading))
        self._heading = heading
        if not bearings.size:
            return 0.0
        self._sense = self._sense or math.copysign(1.0, bearings[np.abs(bearings).argmin()])
        is_left = (self._sense * bearings % math.tau).min() < math.tau - self._turned
        return self._sense if is_left else 0.0


class Sweep:
    """Headings to turn through, one after the other, so that the range sensor hears what stands about a place."""

    def __init__(self, at: Pose, headings: Iterable[float], *, is_all_round: bool = False) -> None:
        self.is_all_round = is_all_round
        self._at = at
        self._headings = list(headings)

    @classmethod
    def ahead(cls, at: Pose, bearing: float) -> Sweep:
        """Return a sweep over what lies at a bearing, its nearer side first."""
        middle = at.heading + bearing
        sides = middle + AHEAD_RAD, middle - AHEAD_RAD
        return cls(at, sorted(sides, key=lambda side: abs(wrap_angle(side - at.heading))))

    @classmethod
    def all_round(cls, at: Pose) -> Sweep:
        """Return a whole turn."""
        return cls(at, (at.heading + part * math.tau / 3 for part in (1, 2, 3)), is_all_round=True)

    def is_about(self, pose: Pose, reach: float) -> bool:
        """Return whether what was learnt holds for a robot at ``pose``: it has not moved on by its own ``reach``."""
        return pose.distance_to(self._at.x, self._at.y) < reach

    def sense(self, heading: float) -> float:
        """Return 1 to turn left, -1 to turn right, 0 where all headings were turned to."""
        while self._headings:
            bearing = wrap_angle(self._headings[0] - heading)
            if abs(bearing) > TURNED_RAD:
                return math.copysign(1.0, bearing)
            self._headings.pop(0)
        return 0.0


NO_SWEEP = Sweep(Pose(math.inf, math.inf, 0.0), ())
