"""Detects that the robot is blocked, and drives it away from what blocks it."""

from __future__ import annotations

import math

from robotcore.geometry import Pose, Twist, wrap_angle

BLOCKED_S = 0.8
"""A robot that makes no progress for this time is blocked.

It is shorter than the time after which the safety rules report a wheel that does not follow its command.
"""

MAX_TICK_S = 0.25
"""The longest time that counts for one tick. A loop that was suspended is no blockage."""

PROGRESS_M, PROGRESS_RAD = 0.02, 0.1
"""The least distance and the least angle that count as progress."""

COMMANDED_M, COMMANDED_RAD = 0.05, 0.5
"""The least commanded distance and angle without progress. Less may be the lag of the wheels."""

ATTEMPTS = 2
"""The number of blockages without progress between them that are reported.

After more of them the app keeps its command, so that the safety rules can report the wheels.
"""


class BlockageDetector:
    """Detects that the robot does not move although the app commands a motion.

    The range guard may hold the robot, or its body may touch an obstacle that no sensor points at.

    >>> detector = BlockageDetector()
    >>> here, forward = Pose(0.0, 0.0, 0.0), Twist(0.2, 0.0)
    >>> [detector.observe(tick / 4, here, forward) for tick in range(6)]
    [False, False, False, False, True, False]
    """

    def __init__(self) -> None:
        self._blockages = 0
        self._last = self._elapsed_s = 0.0
        self._start, self._direction = Pose(0.0, 0.0, 0.0), (0.0, 0.0)
        self._commanded_m = self._commanded_rad = 0.0

    def observe(self, now: float, pose: Pose, command: Twist) -> bool:
        """Return whether the robot is blocked. Call it once in each tick.

        now: the time in seconds.
        pose: the robot's pose now, by odometry.
        command: the velocity that the app commanded in the last tick.
        """
        direction = _direction(command)
        if self._has_moved(pose):
            self._blockages = 0
        elif direction == self._direction:
            return self._is_blocked(now, command)
        self._begin(now, pose, direction)
        return False

    def _has_moved(self, pose: Pose) -> bool:
        is_turn = not self._direction[0]
        if is_turn:
            return abs(wrap_angle(pose.heading - self._start.heading)) > PROGRESS_RAD
        return pose.distance_to(self._start.x, self._start.y) > PROGRESS_M

    def _is_blocked(self, now: float, command: Twist) -> bool:
        passed, self._last = min(now - self._last, MAX_TICK_S), now
        self._elapsed_s += passed
        self._commanded_m += abs(command.linear) * passed
        self._commanded_rad += abs(command.angular) * passed
        is_commanded = self._commanded_m > COMMANDED_M or (not command.linear and self._commanded_rad > COMMANDED_RAD)
        if self._elapsed_s < BLOCKED_S or not is_commanded or self._blockages >= ATTEMPTS:
            return False
        self._blockages += 1
        self._elapsed_s = self._commanded_m = self._commanded_rad = 0.0
        return True

    def _begin(self, now: float, pose: Pose, direction: tuple[float, float]) -> None:
        self._last = now
        self._start, self._direction = pose, direction
        self._elapsed_s = self._commanded_m = self._commanded_rad = 0.0


def _direction(command: Twist) -> tuple[float, float]:
    """Return the signs of the two velocities. Along an arc, the turn's sign is left out, because it may alternate."""
    linear = math.copysign(1.0, command.linear) if command.linear else 0.0
    angular = math.copysign(1.0, command.angular) if command.angular and not linear else 0.0
    return linear, angular


RETREAT_M = 0.1
"""The distance of a retreat."""

RETREAT_M_S = 0.1
"""The velocity of a retreat. It is low because no sensor points backward."""

TURN_BACK_RAD = 0.3
"""The angle by which a robot turns back after a blocked turn."""

AHEAD_M = 0.4
"""After a blocked turn the robot drives forward if the free distance ahead is greater than this, else backward."""


class Retreat:
    """A motion away from an obstacle: back along a blocked way, or back from a blocked turn and then a little away.

    It does not end before the robot has moved. If the robot cannot move at all, the safety rules report the wheels.

    start: the robot's pose.
    blocked: the command that did not move the robot.
    ahead: the free distance ahead, in metres.
    """

    def __init__(self, start: Pose, blocked: Twist, ahead: float) -> None:
        self._start = start
        self._turn_back = 0.0 if blocked.linear else -math.copysign(1.0, blocked.angular)
        is_forward = blocked.linear < 0 or (not blocked.linear and ahead > AHEAD_M)
        self._sense = 1.0 if is_forward else -1.0

    def velocity(self, pose: Pose, turn: float) -> Twist | None:
        """Return the velocity for this tick, or None at the end of the retreat.

        pose: the robot's pose now, by odometry.
        turn: the greatest turn rate, in rad/s.
        """
        if self._turn_back and abs(wrap_angle(pose.heading - self._start.heading)) < TURN_BACK_RAD:
            return Twist(0.0, self._turn_back * turn)
        self._turn_back = 0.0
        if pose.distance_to(self._start.x, self._start.y) < RETREAT_M:
            return Twist(self._sense * RETREAT_M_S, 0.0)
        return None
