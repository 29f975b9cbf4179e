"""The motion of servos, and the present mounts of the devices on them.

A simulator computes the true motion. A run assumes the same motion, because servos do not measure their angle.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from robotcore.description import Mount, RobotDescription
from robotcore.hal.clock import Clock

__all__ = ["Joint", "Joints"]

ROUNDED_RAD = 1e-5
"""For a smaller motion, in radians, the angle in the middle is more precise than a difference of logarithms."""

HISTORY_S = 10.0
"""The time for which a joint stores its motion, in seconds. It is longer than the greatest age of a sample."""


class _Motion(NamedTuple):
    since: float
    start: float
    target: float


class Joint:
    """An angle that moves towards its target at a constant rate.

    >>> from robotcore.hal.clock import SteppedClock
    >>> clock = SteppedClock(20.0, lambda steps: None)
    >>> joint = Joint(clock, angle=0.0, rate=2.0)
    >>> joint.turn_to(-1.0)
    >>> clock.sleep_until(0.25)
    True
    >>> joint.angle
    -0.5
    """

    def __init__(self, clock: Clock, angle: float, rate: float) -> None:
        """Create a joint at rest.

        angle: the angle at first, in radians.
        rate: the speed of the motion in rad/s.
        """
        self._clock, self._rate = clock, rate
        self._motions = deque([_Motion(clock.now(), angle, angle)])

    @property
    def angle(self) -> float:
        """The present angle, in radians."""
        return self.angle_at(self._clock.now())

    def angle_at(self, time: float) -> float:
        """Return the angle at a time in seconds, in radians. The joint stores the last `HISTORY_S` seconds."""
        motion = next((each for each in reversed(self._motions) if each.since <= time), self._motions[0])
        way = motion.target - motion.start
        turned = self._rate * max(0.0, time - motion.since)
        return motion.target if turned >= abs(way) else motion.start + math.copysign(turned, way)

    def mean_tangent(self, since: float, until: float) -> float:
        """Return the mean of the angle's tangent between two times in seconds, both after the last `turn_to`.

        At a constant speed, it is proportional to the mean curvature of the path of a robot that steers. The integral
        of tan x is -ln cos x.
        """
        first, last = self.angle_at(since), self.angle_at(until)
        if first == last or until <= since:
            return math.tan(last)
        way, moving = last - first, abs(last - first) / self._rate
        while_moving = math.tan(first + way / 2)
        if abs(way) > ROUNDED_RAD:
            while_moving = math.log(math.cos(first) / math.cos(last)) / way
        share = min(1.0, moving / (until - since))
        return while_moving * share + math.tan(last) * (1 - share)

    def turn_to(self, angle: float) -> None:
        """Move from the present angle towards another target, in radians."""
        now = self._clock.now()
        self._motions.append(_Motion(now, self.angle_at(now), angle))
        while self._motions[1].since < now - HISTORY_S:
            self._motions.popleft()


class Joints:
    """The joints of a robot's servos. Each begins at the servo's rest angle.

    >>> from robotcore.description import load_robot
    >>> from robotcore.hal.clock import SteppedClock
    >>> robot, clock = load_robot("scout"), SteppedClock(20.0, lambda steps: None)
    >>> joints = Joints(robot, clock)
    >>> joints["pan"].turn_to(0.5)
    >>> clock.sleep_until(1.0)
    True
    >>> round(joints.locate(robot.first_of("camera").mount).yaw_rad, 3)  # of the camera on the servo
    0.5
    """

    def __init__(self, robot: RobotDescription, clock: Clock) -> None:
        servos = robot.all_of("servo")
        self._mounts = {servo.name: servo.mount for servo in servos}
        self._joints = {each.name: Joint(clock, each.rest_angle_rad, each.max_velocity_rad_s) for each in servos}

    def __contains__(self, servo: str) -> bool:
        """Return whether the robot has a servo with this name."""
        return servo in self._joints

    def __getitem__(self, servo: str) -> Joint:
        """Return the joint of a servo."""
        return self._joints[servo]

    def locate(self, mount: Mount, time: float | None = None) -> Mount:
        """Return the mount of a device, which the servos below it have turned.

        time: the time in seconds; None for the present time.
        """
        carrier = mount.on
        while carrier:
            axis, joint = self._mounts[carrier], self._joints[carrier]
            angle = joint.angle if time is None else joint.angle_at(time)
            mount = mount.turn(angle, axis.x_m, axis.y_m)
            carrier = axis.on
        return mount
