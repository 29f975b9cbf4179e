"""The differential drive: two wheels side by side, and where they have taken the robot."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Protocol

from robotcore.geometry import DifferentialGeometry, Pose, Twist, Wheels, to_float
from robotcore.hal.clock import Clock

COMMANDS = 200
"""How many commands are kept, so as to make up for an encoder that is late: a second at 200 Hz."""


class WheelStage(Protocol):
    """What stands between a drive and its motors."""

    def ask(self, wheels: Wheels) -> Wheels: ...
    def stop(self) -> None: ...


class DifferentialDrive:
    """Moves the robot. The last command of a tick counts; it is sent when the tick ends.

    Each command returns what will in fact be sent, after the limits and the range guard. ``reach`` is the radius of the
    circle that the robot needs to turn on the spot, in metres.
    """

    def __init__(
        self,
        geometry: DifferentialGeometry,
        stage: WheelStage,
        odometry: Odometry,
        max_wheel_velocity: float,
        reach: float = 0.0,
    ) -> None:
        self.geometry = geometry
        self.reach = reach
        self.max_linear = max_wheel_velocity * geometry.wheel_radius
        self.max_angular = 2 * self.max_linear / geometry.track
        self._stage = stage
        self._odometry = odometry

    def set_velocity(self, linear: float, angular: float) -> Twist:
        """Drive at ``linear`` m/s, turning left at ``angular`` rad/s."""
        wheels = self._stage.ask(self.geometry.to_wheels(to_float(linear), to_float(angular)))
        return self.geometry.to_twist(wheels)

    def set_wheels(self, left: float, right: float) -> Wheels:
        """Turn the wheels at these velocities, rad/s."""
        return self._stage.ask(Wheels(to_float(left), to_float(right)))

    def stop(self) -> None:
        """Stop at once, past the acceleration limit."""
        self._stage.stop()

    def track(self) -> None:
        """Take in what the wheels have turned; the loop sees to it once a tick, so that every arc is a short one."""
        self._odometry.pose()

    @property
    def pose(self) -> Pose:
        """Where the wheels have taken the robot since it was opened: the middle of its axle."""
        return self._odometry.pose()


class Odometry:
    """Adds up the arcs that two wheels have rolled since their angles were zero.

    From one reading to the next the wheels count as having kept their proportion: exact where they did.
    """

    def __init__(self, geometry: DifferentialGeometry, angles: Callable[[], Wheels]) -> None:
        self._geometry = geometry
        self._angles = angles
        self._pose = Pose(0.0, 0.0, 0.0)
        self._last = Wheels(0.0, 0.0)

    def pose(self) -> Pose:
        """Return the pose after what the wheels have turned until now."""
        angles = self._angles()
        last = self._last
        rolled = self._geometry.to_twist(Wheels(angles.left - last.left, angles.right - last.right))
        self._pose = self._pose.advanced(rolled.linear, rolled.angular)
        self._last = angles
        return self._pose


class CommandIntegrator:
    """The angles that two wheels would have turned to if they followed their commands: for a drive without encoders."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._since = clock.now()
        self._velocity = self._angle = Wheels(0.0, 0.0)
        self._history: deque[tuple[float, Wheels]] = deque(maxlen=COMMANDS)

    def turn_at(self, wheels: Wheels, now: float) -> None:
        """Note a new commanded velocity, in rad/s, at a time that an app may not see yet."""
        self._angle = self._angles_at(now)
        self._velocity = wheels
        self._history.append((now, wheels))

    def angles(self) -> Wheels:
        """Return the angles until now, in radians."""
        return self._angles_at(self._clock.now())

    def rotation_since(self, time: float) -> Wheels:
        """Return how far they would have turned from ``time`` until now, in radians; from the oldest command on."""
        left = right = 0.0
        until = self._clock.now()
        for since, velocity in reversed(tuple(self._history)):
            if until <= time:
                break
            passed = max(0.0, until - max(since, time))
            left, right = left + velocity.left * passed, right + velocity.right * passed
            until = min(until, since)
        return Wheels(left, right)

    def _angles_at(self, now: float) -> Wheels:
        if now == self._since:
            return self._angle
        passed, self._since = now - self._since, now
        (left, right), velocity = self._angle, self._velocity
        self._angle = Wheels(left + velocity.left * passed, right + velocity.right * passed)
        return self._angle
