"""How to move along a way, and how to turn bearings into velocities."""

from __future__ import annotations

import math

from robotcore.autonomy.navigation.ground import NO_WAY, Ground, Way
from robotcore.autonomy.navigation.paths import Cell, are_straight_ways
from robotcore.geometry import Pose, Twist

CARROT_M = 0.5
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
    """Follows a way: drives at the farthest place of it, within CARROT_M, to which it can be cut short.

    Pure pursuit: Coulter, Implementation of the pure pursuit path tracking algorithm, 1992.
    """

    def __init__(self, ground: Ground, steering: Steering) -> None:
        self._ground = ground
        self._steering = steering
        self.start(NO_WAY)

    def start(self, way: Way) -> None:
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
        """Return the farthest place of the way, within CARROT_M, to which it is straight; forget those before."""
        limit = round(CARROT_M / self._ground.grid.cell)
        ahead = self._path[: 2 * limit]
        straight = are_straight_ways(self._open, [here], ahead)
        near = [index for index, cell in enumerate(ahead) if straight[index] and math.dist(here, cell) <= limit]
        self._path = self._path[max(near, default=0) :]
        return self._path[0]
