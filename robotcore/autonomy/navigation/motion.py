"""Velocities for the robot's motions: along a path, to a target, and in turns that scan the surroundings."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from robotcore.autonomy.navigation.grid_paths import Angles, Cell, is_straight_way
from robotcore.autonomy.navigation.planner import NO_PATH, GridPath, Traversability
from robotcore.geometry import Pose, Twist, wrap_angle

LOOKAHEAD_M = 0.5
"""The look-ahead distance of pure pursuit, in metres. With a longer one the robot cuts corners more."""

ARRIVED_M = 0.05
"""The robot has reached a point that is nearer than this. It is about the length of a cell."""

TURN_FIRST_RAD = 0.4
"""On a path, the robot turns on the spot towards a point at a larger bearing, because an arc needs more room."""

MAX_APPROACH_RAD = 0.3
"""The robot turns on the spot towards a target at a larger bearing before it drives to the target."""

TURN_GAIN = 2.5
"""The angular velocity towards a point, in rad/s for each radian of the point's bearing."""

SLOWDOWN = 1.5
"""The velocity towards a target, in m/s for each metre that the robot still has to drive."""

BACK_M_S = 0.05
"""The greatest velocity backward. It is low because no sensor points backward."""

MIN_SPEED_SHARE = 0.3
"""The fraction of the full speed at which the robot arrives at the end of a path."""

BRAKING_M = 0.3
"""Along a path, the velocity is the full speed times ``MIN_SPEED_SHARE + distance / BRAKING_M``, at most the full one.

The distance is that to the point to which the robot steers, in metres.
"""


class Steering:
    """Converts bearings and distances to velocities.

    speed: the greatest velocity forward, in m/s.
    turn: the greatest turn rate, in rad/s.

    >>> Steering(speed=0.2, turn=1.0).turn_to(-0.1)
    -0.25
    """

    def __init__(self, speed: float, turn: float) -> None:
        self.speed = speed
        self.turn = turn

    def turn_to(self, bearing: float) -> float:
        """Return the angular velocity in rad/s that turns the robot towards a bearing in radians."""
        return max(-self.turn, min(self.turn, TURN_GAIN * bearing))

    def steer(self, bearing: float, away: float) -> Twist:
        """Return the velocity at which to drive to a point of a path.

        bearing: the direction of the point from the robot, in radians.
        away: the distance of the point from the robot, in metres.
        """
        if abs(bearing) > TURN_FIRST_RAD:
            return Twist(0.0, self.turn_to(bearing))
        speed = self.speed * min(1.0, MIN_SPEED_SHARE + away / BRAKING_M)
        return Twist(speed * math.cos(bearing), self.turn_to(bearing))

    def approach(self, bearing: float, gap: float) -> Twist:
        """Return the velocity at which to drive towards a target, or backward away from it.

        bearing: the direction of the target from the robot, in radians.
        gap: how far the robot still has to drive, in metres. It drives backward if this is negative.
        """
        speed = min(self.speed, SLOWDOWN * gap) if abs(bearing) < MAX_APPROACH_RAD else 0.0
        return Twist(max(speed, -BACK_M_S), self.turn_to(bearing))


class Follower:
    """Follows a path by pure pursuit.

    The robot steers to the farthest point of the path within `LOOKAHEAD_M` that it can reach on a straight line. See
    Coulter, Implementation of the pure pursuit path tracking algorithm, 1992.
    """

    def __init__(self, ground: Traversability, steering: Steering) -> None:
        self._ground = ground
        self._steering = steering
        self.start(NO_PATH)

    def start(self, path: GridPath) -> None:
        """Begin to follow a path."""
        self._path, self._open = np.array(path.cells, np.intp).reshape(-1, 2), path.open_cells

    @property
    def path(self) -> tuple[Cell, ...]:
        """The cells of the path that the robot has not reached."""
        return tuple((row, column) for row, column in self._path.tolist())

    def follow(self, pose: Pose) -> Twist | None:
        """Return the velocity along the path, or None at its end. Plan the path again if it is blocked."""
        grid = self._ground.grid
        here = grid.cell_of(pose.x, pose.y)
        if (grid.evidence[tuple(self._path.T)] > 0).any():
            self.start(self._ground.find_path(here, self.path[-1]))
        while len(self._path):
            x, y = grid.point_of(*self._find_lookahead(here))
            if (away := pose.distance_to(x, y)) >= ARRIVED_M:
                return self._steering.steer(pose.bearing_to(x, y), away)
            self._path = self._path[1:]
        return None

    def _find_lookahead(self, here: Cell) -> Cell:
        """Return the cell to which the robot steers, and delete the cells before it from the path."""
        limit = round(LOOKAHEAD_M / self._ground.grid.cell)
        ahead = [(row, column) for row, column in self._path[: 2 * limit].tolist()]
        near = (index for index in reversed(range(len(ahead))) if math.dist(here, ahead[index]) <= limit)
        farthest = next((index for index in near if is_straight_way(self._open, here, ahead[index])), 0)
        self._path = self._path[farthest:]
        return ahead[farthest]


HEADING_TOLERANCE_RAD = 0.1
"""The robot has turned to a heading if its own heading differs from it by less than this."""

SCAN_RAD = 0.8
"""The angle to the left and to the right of a bearing to which `SensorSurvey.ahead` turns."""


class CameraLook:
    """A turn of at most 360° in one direction, until the camera has seen the bearings that it should see."""

    def __init__(self, heading: float) -> None:
        self._heading = heading
        self._turned = 0.0
        self._sense = 0.0

    def turn_direction(self, heading: float, bearings: Angles) -> float:
        """Return 1 to turn left, -1 to turn right, or 0 at the end of the turn. Call it once in each tick.

        heading: the robot's heading in radians.
        bearings: the bearings that the camera should still see, in radians.
        """
        self._turned += abs(wrap_angle(heading - self._heading))
        self._heading = heading
        if not bearings.size:
            return 0.0
        self._sense = self._sense or math.copysign(1.0, bearings[np.abs(bearings).argmin()])
        is_left = (self._sense * bearings % math.tau).min() < math.tau - self._turned
        return self._sense if is_left else 0.0


class SensorSurvey:
    """A turn through several headings, so that the range sensor measures the surroundings."""

    def __init__(self, at: Pose, headings: Iterable[float], *, is_full_turn: bool = False) -> None:
        self.is_full_turn = is_full_turn
        self._at = at
        self._headings = list(headings)

    @classmethod
    def ahead(cls, at: Pose, bearing: float) -> SensorSurvey:
        """Return a scan to the left and to the right of a bearing in radians, the side nearer to the heading first."""
        middle = at.heading + bearing
        sides = middle + SCAN_RAD, middle - SCAN_RAD
        return cls(at, sorted(sides, key=lambda side: abs(wrap_angle(side - at.heading))))

    @classmethod
    def full_turn(cls, at: Pose) -> SensorSurvey:
        """Return a scan over a full turn."""
        return cls(at, (at.heading + part * math.tau / 3 for part in (1, 2, 3)), is_full_turn=True)

    def is_near(self, pose: Pose, reach: float) -> bool:
        """Return whether a pose is less than ``reach`` metres from the place of this scan."""
        return pose.distance_to(self._at.x, self._at.y) < reach

    def turn_direction(self, heading: float) -> float:
        """Return 1 to turn left, -1 to turn right, or 0 if the robot has turned to all headings of the scan."""
        while self._headings:
            bearing = wrap_angle(self._headings[0] - heading)
            if abs(bearing) > HEADING_TOLERANCE_RAD:
                return math.copysign(1.0, bearing)
            self._headings.pop(0)
        return 0.0


NO_SCAN = SensorSurvey(Pose(math.inf, math.inf, 0.0), ())
