"""Detects that a robot is blocked during a manoeuvre."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from robotcore.geometry import Pose, Twist
from robotcore.hal.robot import Robot
from robotcore.kinds.bumper import Bumper

GUARDED_S = 0.5
"""The time for which the range guard may hold the robot, in seconds."""

HELD_SHARE = 0.1
"""The range guard holds the robot if it leaves less than this share of the speed forward."""

STALLED_S = 0.8
"""The shortest time of a stall, in seconds. It is shorter than the time after which the safety rules end the run."""

STALLED_M = 0.03
"""The shortest commanded way of a wheel in a stall, in metres. Less may be the lag of the wheels."""

STALLED_SHARE = 0.25
"""The wheels stall if they turn by less than this share of the commanded way. With lag or slip they turn more."""


class _Step(NamedTuple):
    """The state at the start of a tick."""

    time: float
    pose: Pose
    commanded: Pose
    """The pose that the commands since the start would have reached."""


class BlockageMonitor:
    """Finds the cause that blocks a robot. A manoeuvre calls the methods in each tick."""

    def __init__(self, robot: Robot) -> None:
        self._bumpers = robot.all(Bumper)
        self._half_track = robot.drive.geometry.track / 2
        self._steps: deque[_Step] = deque()
        self._guarded_s = self._time = 0.0
        self._commanded = Pose(0.0, 0.0, 0.0)

    def has_contact(self, direction: float | None) -> bool:
        """Return whether a bumper is pressed.

        direction: 1 for the bumpers at the front, -1 for those at the rear, None for all.
        """
        return any(
            each.read().is_pressed
            for each in self._bumpers
            if direction is None or math.cos(each.direction) * direction > 0
        )

    def find_cause(self, pose: Pose, command: Twist, sent: Twist, period: float, direction: float | None) -> str:
        """Return the cause of a blockage, ``range-guard``, ``contact`` or ``wheels``; ``""`` without a blockage.

        pose: the pose of the robot before the command.
        command: the command of the manoeuvre.
        sent: the command after the safety rules.
        period: the duration of a tick in seconds.
        direction: 1 forward, -1 backward; None on the spot.
        """
        # On the spot, a motion forward only corrects the place. The turn does not need it.
        is_held = direction is not None and command.linear > 0 and sent.linear < HELD_SHARE * command.linear
        self._guarded_s = max(0.0, self._guarded_s + (period if is_held else -period))
        if self._guarded_s >= GUARDED_S:
            return "range-guard"
        if self._is_stalled(pose):
            return "contact" if self.has_contact(None) else "wheels"
        self._time += period
        self._commanded = self._commanded.advance(sent.linear * period, sent.angular * period)
        return ""

    def _is_stalled(self, pose: Pose) -> bool:
        steps = self._steps
        steps.append(_Step(self._time, pose, self._commanded))
        while len(steps) > 1 and self._is_long_enough(steps[1]):
            steps.popleft()
        first = steps[0]
        way, commanded = self.measure_way(first.pose, pose), self.measure_way(first.commanded, self._commanded)
        return self._is_long_enough(first) and way < STALLED_SHARE * commanded

    def _is_long_enough(self, since: _Step) -> bool:
        commanded = self.measure_way(since.commanded, self._commanded)
        return self._time - since.time >= STALLED_S and commanded >= STALLED_M

    def measure_way(self, start: Pose, pose: Pose) -> float:
        """Return the way of the outer wheel between two near poses, in metres."""
        turned = abs(pose.heading - start.heading) * self._half_track
        return start.distance_to(pose.x, pose.y) + turned
