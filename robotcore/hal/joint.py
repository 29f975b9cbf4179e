"""The motion of servos, and the present mounts of the devices on them.

A simulator computes the true motion. A run assumes the same motion, because servos do not measure their angle.
"""

from __future__ import annotations

import math

from robotcore.description import Mount, RobotDescription
from robotcore.hal.clock import Clock

ROUNDED_RAD = 1e-5
"""For a smaller motion, in radians, the angle in the middle is more precise than a difference of logarithms."""


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
        self._start = self._target = angle
        self._since = clock.now()

    @property
    def angle(self) -> float:
        """The present angle, in radians."""
        return self.angle_at(self._clock.now())

    def angle_at(self, time: float) -> float:
        """Return the angle at a time in seconds, in radians: at most that of the last `turn_to` for an earlier time."""
        way = self._target - self._start
        turned = self._rate * max(0.0, time - self._since)
        return self._target if turned >= abs(way) else self._start + math.copysign(turned, way)

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
        self._start, self._since, self._target = self.angle, self._clock.now(), angle


class Joints:
    """The joints of a robot's servos. Each begins at the servo's rest angle."""

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

    def locate(self, mount: Mount) -> Mount:
        """Return the present mount of a device, which the servos below it have turned."""
        carrier = mount.on
        while carrier:
            axis = self._mounts[carrier]
            mount = mount.turn(self._joints[carrier].angle, axis.x_m, axis.y_m)
            carrier = axis.on
        return mount
