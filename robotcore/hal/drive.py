"""The differential drive, and its odometry."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import NamedTuple, Protocol

from robotcore.geometry import DifferentialGeometry, Pose, Twist, Wheels, to_float
from robotcore.hal.clock import Clock

__all__ = ["DifferentialDrive", "Odometry", "WheelPath"]

COMMANDS = 200
"""The number of commands that a `CommandIntegrator` stores: those of one second at 200 Hz."""


class WheelStage(Protocol):
    """The interface through which a `DifferentialDrive` sends commands to its motors."""

    def ask(self, wheels: Wheels) -> Wheels:
        """Set the wheel velocities for this tick, in rad/s. Return the velocities after the safety rules, in rad/s."""

    def stop(self) -> None:
        """Stop all motors now."""


class DifferentialDrive:
    """Moves the robot with two driven wheels. The last command of a tick is sent at the end of the tick.

    A robot whose wheels skid or steer has the same methods. Its two wheels are those of a robot with two driven wheels
    that moves in the same way.

    Each command returns the velocity that will be sent, after the limits and the range guard. ``max_linear`` in m/s
    and ``max_angular`` in rad/s are the greatest velocities. An app gets the drive as ``robot.drive``.

    geometry: the radius of the wheels and the track.
    stage: sends the commands to the motors.
    odometry: computes the pose.
    max_wheel_velocity: the greatest velocity of a wheel, in rad/s.
    reach: the radius of the circle that the robot needs to turn on the spot, in metres.
    min_turn_radius: the radius of the sharpest turn, in metres; 0 for a robot that can turn on the spot.
    inner_reach: the radius of the circle between the wheels, where nothing else can be, in metres.
    max_acceleration: the greatest acceleration that a run commands to a wheel, in m/s²; infinite without a limit.
    deceleration: that of a braking robot, in m/s².

    >>> import robotcore
    >>> robot = robotcore.testing.MockRobot(range=[0.84]).layered
    >>> robot.drive.set_velocity(0.1, 0.0)  # m/s forward, rad/s to the left
    Twist(linear=0.0975 m/s, angular=0 rad/s)
    >>> robot.drive.set_wheels(1.0, 1.0)  # rad/s
    Wheels(left=1, right=1)
    >>> robot.drive.pose
    Pose(x=0 m, y=0 m, heading=0 rad)
    >>> robot.drive.stop()
    """

    def __init__(
        self,
        geometry: DifferentialGeometry,
        stage: WheelStage,
        odometry: Odometry,
        max_wheel_velocity: float,
        reach: float = 0.0,
        min_turn_radius: float = 0.0,
        inner_reach: float | None = None,
        max_acceleration: float = math.inf,
        deceleration: float = 0.5,
    ) -> None:
        self.geometry = geometry
        self.reach = reach
        self.min_turn_radius = min_turn_radius
        self.inner_reach = geometry.track / 2 if inner_reach is None else inner_reach
        self.max_acceleration, self.deceleration = max_acceleration, deceleration
        self.max_linear = max_wheel_velocity * geometry.wheel_radius
        self.max_angular = 2 * self.max_linear / (geometry.track + 2 * min_turn_radius)
        self._stage = stage
        self._odometry = odometry

    def set_velocity(self, linear: float, angular: float) -> Twist:
        """Set the velocity for this tick. Return the twist that will be sent.

        linear: the forward velocity in m/s, negative for backward.
        angular: the turn rate in rad/s, positive to the left.
        """
        wheels = self._stage.ask(self.geometry.to_wheels(to_float(linear), to_float(angular)))
        return self.geometry.to_twist(wheels)

    def set_wheels(self, left: float, right: float) -> Wheels:
        """Set the velocities of the wheels for this tick. Return the velocities that will be sent.

        left, right: the velocities in rad/s, positive forward.
        """
        return self._stage.ask(Wheels(to_float(left), to_float(right)))

    def stop(self) -> None:
        """Stop all motors now, without the acceleration limit."""
        self._stage.stop()

    def track(self) -> None:
        """Update the odometry. The control loop calls this in each tick, so that the odometry adds only short arcs."""
        self._odometry.pose()

    @property
    def pose(self) -> Pose:
        """The pose of the axle's centre by odometry, relative to its pose when the robot was opened."""
        return self._odometry.pose()

    @property
    def latest_pose(self) -> Pose:
        """The result of the last call of `pose` or `track`. This reads no encoder."""
        return self._odometry.latest

    def __repr__(self) -> str:
        x, y, heading = self.latest_pose
        return f"<DifferentialDrive at x={x:.2f} m, y={y:.2f} m, heading={heading:.2f} rad>"


class WheelPath(NamedTuple):
    """The angles of the two wheels, and how the wheels came to them since the last reading.

    >>> from robotcore.geometry import Wheels
    >>> WheelPath(Wheels(left=1.0, right=3.0), between=(Wheels(1.0, 1.0),)).angles.right
    3.0
    """

    angles: Wheels
    """The present angles in radians."""
    between: tuple[Wheels, ...] = ()
    """The angles between the last reading and this one in radians, the oldest first. Without them, one arc leads to the
    present angles."""


class Odometry:
    """Computes the pose of a robot from the angles of its two driven wheels.

    Each call of `pose` adds an arc for each pair of angles in the path since the last call. An arc is exact if the
    ratio of the wheels' velocities was constant in it. ``latest`` is the result of the last call.

    geometry: the radius of the wheels and the track.
    read_path: returns the path of the wheels since its last call.

    >>> from robotcore.geometry import DifferentialGeometry, Wheels
    >>> from robotcore.hal.drive import WheelPath
    >>> path = WheelPath(Wheels(1.0, 3.0), between=(Wheels(1.0, 1.0),))  # straight on, and then to the left
    >>> Odometry(DifferentialGeometry(wheel_radius=0.05, track=0.2), lambda: path).pose()
    Pose(x=0.0979 m, y=0.0122 m, heading=0.5 rad)
    """

    def __init__(self, geometry: DifferentialGeometry, read_path: Callable[[], WheelPath]) -> None:
        self._geometry = geometry
        self._read_path = read_path
        self.latest = Pose(0.0, 0.0, 0.0)
        self._last = Wheels(0.0, 0.0)

    def pose(self) -> Pose:
        """Read the path of the wheels, and return the new pose."""
        path = self._read_path()
        for angles in path.between:
            self._add_arc(angles)
        self._add_arc(path.angles)
        return self.latest

    def _add_arc(self, angles: Wheels) -> None:
        last, self._last = self._last, angles
        if angles == last:  # mostly a further reading in a tick
            return
        distance, turn = self._geometry.to_arc(angles.left - last.left, angles.right - last.right)
        self.latest = self.latest.advance(distance, turn)


class CommandIntegrator:
    """Computes the angles of the wheels from their commands, for a robot without encoders or with old samples."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._since = clock.now()
        self._velocity = self._angle = Wheels(0.0, 0.0)
        self._history: deque[tuple[float, Wheels]] = deque(maxlen=COMMANDS)

    def turn_at(self, wheels: Wheels, now: float) -> None:
        """Add a command. From the time ``now`` on, in seconds, the wheels turn at these velocities in rad/s."""
        self._angle = self._angles_at(now)
        self._velocity = wheels
        self._history.append((now, wheels))

    def angles(self) -> Wheels:
        """Return the present wheel angles in radians."""
        return self._angles_at(self._clock.now())

    def rotation_since(self, time: float) -> Wheels:
        """Return the angles by which the commands have turned the wheels since ``time``, in radians.

        Only the last `COMMANDS` commands count.
        """
        left = right = 0.0
        until = self._clock.now()
        if until <= time:
            return Wheels(left, right)
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
