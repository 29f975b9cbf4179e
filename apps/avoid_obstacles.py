"""Wander without touching obstacles: look around, drive along a free corridor, and look around again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robotcore import Behaviour, Pose, Positive, Robot, Role, Status, Truth
from robotcore.geometry import wrap_angle

BEARINGS = np.radians(np.arange(-180.0, 180.0))
MARGIN_M = 0.05
"""The clearance on each side of the corridor."""


@dataclass
class AvoidObstacles(Behaviour):
    """Drives without touching obstacles for a given time.

    A range sensor with a narrow cone does not see what the robot's sides will touch. So the robot first turns once
    around, and then drives only as far as the readings show a corridor that is as wide as the turning robot.
    """

    speed_m_s: Positive = 0.2
    """The greatest velocity forward."""
    turn_rad_s: Positive = 1.5
    """The greatest turn rate."""
    near_m: Positive = 0.3
    """The distance of an obstacle ahead at which the robot stops to look around."""
    duration_s: Positive = 10.0
    """The duration of the run."""

    needs = frozenset({Role.DRIVE, Role.RANGE})
    turns_on_spot = True
    milestones = ("look", "turn", "cruise")

    def __post_init__(self) -> None:
        self._begin_look(0.0)

    def verify(self, truth: Truth) -> bool:
        return truth.contacts == 0

    def step(self, robot: Robot) -> Status:
        act = {"look": self._look, "turn": self._turn, "cruise": self._cruise}[self.state]
        robot.drive.set_velocity(*act(robot, robot.drive.pose))
        return Status.SUCCESS if robot.clock.now() >= self.duration_s else Status.RUNNING

    def _begin_look(self, heading: float) -> None:
        self.state = "look"
        self._end = heading + 2 * np.pi
        self._free = np.zeros_like(BEARINGS)
        self._times: list[float] = []
        self._headings: list[float] = []

    def _look(self, robot: Robot, pose: Pose) -> tuple[float, float]:
        """Turn once around. The free distance at a bearing is the longest reading whose cone covers the bearing.

        The robot has turned on since the sensor measured, so the heading at the time of the sample counts.
        """
        sensor, sample = robot.range, robot.range.read()
        self._times.append(robot.clock.now())
        self._headings.append(pose.heading)
        heading = np.interp(sample.time, self._times, self._headings) + sensor.mount.heading
        distance = min(sample.distance, sensor.max_range)
        in_cone = np.cos(BEARINGS - heading) >= np.cos(sensor.cone / 2)
        self._free[in_cone] = np.maximum(self._free[in_cone], sensor.mount.x + distance)
        if pose.heading < self._end:
            return 0.0, self.turn_rad_s
        self._heading, self._length = self._choose(robot, pose.heading)
        self.state = "turn"
        return 0.0, 0.0

    def _choose(self, robot: Robot, heading: float) -> tuple[float, float]:
        """Return the heading and the length of the longest corridor.

        If several are long, choose the one with the smallest turn.
        """
        width = robot.drive.reach + MARGIN_M
        angles = BEARINGS - BEARINGS[:, None]
        is_beside = (np.abs(self._free * np.sin(angles)) > width) | (np.cos(angles) < 0)
        lengths = np.where(is_beside, np.inf, self._free * np.cos(angles)).min(axis=1) - width
        best = int(np.argmax(np.minimum(lengths, 2 * self.near_m) + 0.01 * np.cos(BEARINGS - heading)))
        return float(BEARINGS[best]), float(lengths[best])

    def _turn(self, robot: Robot, pose: Pose) -> tuple[float, float]:
        bearing = wrap_angle(self._heading - pose.heading)
        if abs(bearing) > 0.05:
            return 0.0, max(-self.turn_rad_s, min(self.turn_rad_s, 3 * bearing))
        self.state, self._from = "cruise", pose
        return 0.0, 0.0

    def _cruise(self, robot: Robot, pose: Pose) -> tuple[float, float]:
        driven = pose.distance_to(self._from.x, self._from.y)
        if driven < self._length and robot.range.read().distance > self.near_m:
            return self.speed_m_s, wrap_angle(self._heading - pose.heading)
        self._begin_look(pose.heading)
        return 0.0, 0.0


if __name__ == "__main__":
    from robotcore.cli.main import run_app

    run_app("avoid-obstacles")
