"""The differential drive, and the odometry of its two wheels."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Protocol

from robotcore.geometry import DifferentialGeometry, Pose, Twist, Wheels, to_float
from robotcore.hal.clock import Clock

COMMANDS = 200
"""The number of commands kept to correct a late encoder: one second at 200 Hz."""


class WheelStage(Protocol):
    """Takes the commands of a drive for its motors."""

    def ask(self, wheels: Wheels) -> Wheels:
        """Take the command of this tick; return the command after the limits. All in rad/s."""

    def stop(self) -> None:
        """Stop both motors now."""


class DifferentialDrive:
    """Moves the robot with two driven wheels. The last command of a tick is sent when the tick ends.

    Each command returns the velocity that will be sent, after the limits and the range guard. ``geometry`` holds the
    wheel radius and the track. ``max_linear`` (m/s) and ``max_angular`` (rad/s) are the limits. ``reach`` is the radius
    of the circle that the robot needs to turn on the spot, in metres.

    >>> import robotcore
    >>> robot = robotcore.testing.MockRobot(range=[0.84]).layered
    >>> robot.drive.set_velocity(0.1, 0.0)
    Twist(linear=0.0975, angular=0.0)
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
        """Drive at ``linear`` m/s and turn left at ``angular`` rad/s; return the twist that will be sent."""
        wheels = self._stage.ask(self.geometry.to_wheels(to_float(linear), to_float(angular)))
        return self.geometry.to_twist(wheels)

    def set_wheels(self, left: float, right: float) -> Wheels:
        """Turn the wheels at ``left`` and ``right`` rad/s; return the velocities that will be sent."""
        return self._stage.ask(Wheels(to_float(left), to_float(right)))

    def stop(self) -> None:
        """Stop at once, without the acceleration limit."""
        self._stage.stop()

    def track(self) -> None:
        """Update the odometry. The loop does this once a tick, so that every arc is short."""
        self._odometry.pose()

    @property
    def pose(self) -> Pose:
        """The pose of the middle of the axle by odometry, relative to its pose when the robot was opened."""
        return self._odometry.pose()

    def __repr__(self) -> str:
        x, y, heading = self._odometry.latest
        return f"<DifferentialDrive at x={x:.2f} m, y={y:.2f} m, heading={heading:.2f} rad>"


class Odometry:
    """Computes a pose from the angles of two wheels.

    It adds one arc for each reading. The arc is exact if the ratio of the two velocities was constant in between.
    ``latest`` is the pose of the last reading.
    """

    def __init__(self, geometry: DifferentialGeometry, angles: Callable[[], Wheels]) -> None:
        self._geometry = geometry
        self._angles = angles
        self.latest = Pose(0.0, 0.0, 0.0)
        self._last = Wheels(0.0, 0.0)

    def pose(self) -> Pose:
        """Read the wheel angles and return the new pose."""
        angles = self._angles()
        last = self._last
        rolled = self._geometry.to_twist(Wheels(angles.left - last.left, angles.right - last.right))
        self.latest = self.latest.advanced(rolled.linear, rolled.angular)
        self._last = angles
        return self.latest


class CommandIntegrator:
    """Integrates wheel commands to wheel angles, for a drive without encoders."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._since = clock.now()
        self._velocity = self._angle = Wheels(0.0, 0.0)
        self._history: deque[tuple[float, Wheels]] = deque(maxlen=COMMANDS)

    def turn_at(self, wheels: Wheels, now: float) -> None:
        """Add a commanded velocity in rad/s, valid from ``now`` on, in seconds."""
        self._angle = self._angles_at(now)
        self._velocity = wheels
        self._history.append((now, wheels))

    def angles(self) -> Wheels:
        """Return the present angles in radians."""
        return self._angles_at(self._clock.now())

    def rotation_since(self, time: float) -> Wheels:
        """Return the rotation from ``time`` until now in radians. It begins with the oldest command that is kept."""
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
