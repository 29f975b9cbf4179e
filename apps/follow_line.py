"""Follow a line on the floor by a line sensor."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robotcore import Behaviour, Pose, Positive, Robot, Role, Status, Truth
from robotcore.kinds import LineSensor

LARGEST_DISTANCE_M = 0.05
"""The robot follows the line if its axle's centre is nowhere farther from it."""

MIN_AHEAD_M = 0.02
"""The least distance from the axle to the seen point, which limits the curvature."""


@dataclass
class FollowLine(Behaviour):
    """Drives along a dark line until it has driven a given distance. If the line is lost, it turns to its last side."""

    speed_m_s: Positive = 0.2
    """The velocity forward."""
    turn_rad_s: Positive = 1.0
    """The velocity of the turn after the line was lost."""
    distance_m: Positive = 6.5
    """The distance to drive."""
    search_s: Positive = 3.0
    """The robot gives up after it has searched the lost line for this time."""

    needs = frozenset({Role.DRIVE, LineSensor})
    milestones = ("follow", "search")

    def __post_init__(self) -> None:
        self._pose, self._driven = Pose(0.0, 0.0, 0.0), 0.0
        self._seen_at, self._side = 0.0, 1.0

    def verify(self, truth: Truth) -> bool | None:
        """Return whether the robot was always near the line, for a lap or for most of the distance."""
        if truth.line is None:
            return None
        least = min(truth.line.length, 0.9 * self.distance_m)
        return truth.line.largest_distance <= LARGEST_DISTANCE_M and truth.line.followed >= least

    def step(self, robot: Robot) -> Status:
        pose, now = robot.drive.pose, robot.clock.now()
        self._driven += pose.distance_to(self._pose.x, self._pose.y)
        self._pose = pose
        sensor = robot.all(LineSensor)[0]
        position = sensor.read_position()
        if position is None:
            return self._search(robot, now)
        self.state, self._seen_at = "follow", now
        if position:
            self._side = math.copysign(1.0, position)
        # The circle through the axle and the seen point, as in pure pursuit.
        curvature = 2 * position / max(sensor.mount.x**2 + position**2, MIN_AHEAD_M**2)
        robot.drive.set_velocity(self.speed_m_s, self.speed_m_s * curvature)
        return Status.SUCCESS if self._driven >= self.distance_m else Status.RUNNING

    def _search(self, robot: Robot, now: float) -> Status:
        """Turn to the side at which the line was last, as sharply as the robot can."""
        self.state = "search"
        if now - self._seen_at > self.search_s:
            self.reason = f"the line was lost for {self.search_s:g} s"
            return Status.FAILURE
        radius = robot.drive.min_turn_radius
        turn_rad_s = min(self.turn_rad_s, self.speed_m_s / radius) if radius else self.turn_rad_s
        robot.drive.set_velocity(radius * turn_rad_s, self._side * turn_rad_s)
        return Status.RUNNING


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("follow-line")
