"""Follow a line on the floor by a line sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robotcore import Behaviour, Pose, Positive, Robot, Role, Status, Truth
from robotcore.kinds import LineSensor

MAX_DISTANCE_M = 0.05
"""The robot follows the line if its axle's centre is nowhere farther from it."""

MIN_AHEAD_M = 0.02
"""The least distance from the axle to the seen point, which limits the curvature."""

EXPECTED_DARKNESS = 0.8
"""The darkness of the line as long as the app has not seen it."""

MIN_CONTRAST = 0.15
"""The least difference in darkness between the line and the floor."""

CONTRAST_DECAY = 0.003
"""The part of the contrast by which it shrinks in each tick, so that it adapts to another floor."""

THRESHOLD = 2 / 3
"""A sensor sees the line if its darkness is greater than this part of the way from the floor's to the line's."""

FIRST_SEARCH_RAD = 0.6
"""How far the robot turns to the side at which the line was last. It then turns back twice as far, and so on."""


@dataclass
class FollowLine(Behaviour):
    """Drives along a dark line until it has driven a given distance. If the line is lost, it turns to both sides."""

    speed_m_s: Positive = 0.2
    """The velocity forward."""
    turn_rad_s: Positive = 1.0
    """The turn rate after the line was lost."""
    distance_m: Positive = 6.5
    """The distance to drive."""
    search_s: Positive = 5.0
    """The robot gives up after it has searched the line for this time."""

    needs = frozenset({Role.DRIVE, LineSensor})
    milestones = ("follow", "search")

    def __post_init__(self) -> None:
        self._pose, self._driven, self._heading = Pose(0.0, 0.0, 0.0), 0.0, 0.0
        self._seen_at, self._side, self._search_angle = 0.0, 1.0, FIRST_SEARCH_RAD
        self._has_seen_line = False
        self._lightest, self._darkest = 1.0, EXPECTED_DARKNESS

    def verify(self, truth: Truth) -> bool | None:
        """Return whether the robot was always near the line, for a lap or for most of the distance."""
        if truth.line is None:
            return None
        least = min(truth.line.length, 0.9 * self.distance_m)
        return truth.line.max_distance <= MAX_DISTANCE_M and truth.line.followed_length >= least

    def step(self, robot: Robot) -> Status:
        pose, now = robot.drive.pose, robot.clock.now()
        self._driven += pose.distance_to(self._pose.x, self._pose.y)
        self._pose = pose
        sensor = robot.all(LineSensor)[0]
        position = self._locate(sensor)
        if position is None:
            return self._search(robot, now)
        self.state, self._seen_at, self._heading, self._search_angle = "follow", now, pose.heading, FIRST_SEARCH_RAD
        self._has_seen_line = True
        if position:
            self._side = math.copysign(1.0, position)
        # The circle through the axle and the seen point, as in pure pursuit.
        curvature = 2 * position / max(sensor.mount.x**2 + position**2, MIN_AHEAD_M**2)
        robot.drive.set_velocity(self.speed_m_s, self.speed_m_s * curvature)
        return Status.SUCCESS if self._driven >= self.distance_m else Status.RUNNING

    def _locate(self, sensor: LineSensor) -> float | None:
        """Return the position of the line, or None. The threshold follows the darkness of the floor and of the line."""
        values = sensor.read().values
        step = CONTRAST_DECAY * (self._darkest - self._lightest)
        self._lightest = max(0.0, min(self._lightest + step, *values))
        self._darkest = min(1.0, max(self._darkest - step, *values))
        if self._darkest - self._lightest < MIN_CONTRAST:
            return None
        return sensor.read_position(self._lightest + THRESHOLD * (self._darkest - self._lightest))

    def _search(self, robot: Robot, now: float) -> Status:
        """Turn to the side at which the line was last, then to the other side, each time farther.

        A robot that steers drives a circle to the last side.
        """
        self.state = "search"
        if now - self._seen_at > self.search_s:
            time = f"{self.search_s:g} s"
            never_seen = f"no line was seen for {time}. Put the robot on a line that is darker than the floor"
            self.reason = f"the line was lost for {time}" if self._has_seen_line else never_seen
            return Status.FAILURE
        radius = robot.drive.min_turn_radius
        if not radius and self._side * (robot.drive.pose.heading - self._heading) > self._search_angle:
            self._side, self._search_angle = -self._side, 2 * self._search_angle
        turn_rad_s = min(self.turn_rad_s, self.speed_m_s / radius) if radius else self.turn_rad_s
        robot.drive.set_velocity(radius * turn_rad_s, self._side * turn_rad_s)
        return Status.RUNNING


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("follow-line")
