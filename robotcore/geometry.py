"""Poses and velocities in the plane, and the kinematics of a differential drive.

In the robot's frame, x points forward, y left and z up. A turn to the left is positive (REP 103).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple


class Twist(NamedTuple):
    """The velocity of a robot in the plane.

    >>> Twist(linear=0.2, angular=-0.5)
    Twist(linear=0.2 m/s, angular=-0.5 rad/s)
    """

    linear: float
    """The forward velocity, in m/s."""
    angular: float
    """The turn rate, in rad/s, positive to the left."""

    def __repr__(self) -> str:
        return f"Twist(linear={_shorten(self.linear)} m/s, angular={_shorten(self.angular)} rad/s)"


class Pose(NamedTuple):
    """A position and a heading in the plane.

    >>> import math
    >>> robot = Pose(1.0, 0.0, math.pi / 2)
    >>> x, y = robot.to_world(2.0, 0.0)  # 2 m ahead of the robot
    >>> round(x, 3), round(y, 3)
    (1.0, 2.0)
    """

    x: float
    """The x coordinate, in metres."""
    y: float
    """The y coordinate, in metres."""
    heading: float
    """The angle from the x axis, in radians, positive to the left."""

    def __repr__(self) -> str:
        x, y, heading = map(_shorten, self)
        return f"Pose(x={x} m, y={y} m, heading={heading} rad)"

    def advance(self, distance: float, turn: float) -> Pose:
        """Return the pose after a motion along an arc of constant curvature.

        distance: the length of the arc in metres, negative for a motion backward.
        turn: the change of the heading in radians, positive to the left.

        The chord of an arc of length s that turns by a has the length s·sinc(a/2) and the direction heading + a/2.

        >>> end = Pose(0.0, 0.0, 0.0).advance(math.pi / 2, turn=math.pi / 2)  # a quarter of a circle of radius 1 m
        >>> round(end.x, 3), round(end.y, 3)
        (1.0, 1.0)
        """
        half = turn / 2
        chord = distance * (math.sin(half) / half if abs(half) > 1e-12 else 1.0)
        middle = self.heading + half
        return Pose(
            self.x + chord * math.cos(middle),
            self.y + chord * math.sin(middle),
            self.heading + turn,
        )

    def compose(self, local: Pose) -> Pose:
        """Convert a pose from this pose's frame to the world's frame, such as the mount of a sensor on a robot."""
        return Pose(*self.to_world(local.x, local.y), self.heading + local.heading)

    def to_world(self, x: float, y: float) -> tuple[float, float]:
        """Convert a point, in metres, from this pose's frame to the world's frame."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return self.x + x * cos - y * sin, self.y + x * sin + y * cos

    def to_local(self, x: float, y: float) -> tuple[float, float]:
        """Convert a point, in metres, from the world's frame to this pose's frame."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        dx, dy = x - self.x, y - self.y
        return dx * cos + dy * sin, dy * cos - dx * sin

    def distance_to(self, x: float, y: float) -> float:
        """Return the distance from this pose to the point (x, y) of the world, in metres."""
        return math.hypot(x - self.x, y - self.y)

    def bearing_to(self, x: float, y: float) -> float:
        """Return the angle from the heading to the direction of the point (x, y) of the world, in radians.

        The result is in (-π, π], positive to the left.

        >>> round(math.degrees(Pose(0.0, 0.0, 0.0).bearing_to(1.0, 1.0)))
        45
        """
        return wrap_angle(math.atan2(y - self.y, x - self.x) - self.heading)


def wrap_angle(angle: float) -> float:
    """Return an angle in radians, changed by a multiple of 2π so that it is in (-π, π].

    >>> import math
    >>> round(math.degrees(wrap_angle(math.radians(350))))
    -10
    """
    wrapped = math.remainder(angle, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


def to_float(value: float) -> float:
    """Return a number as a ``float``, so that later changes of a NumPy array have no effect.

    value: a number, also one of NumPy.

    Raises TypeError for text, which the builtin ``float`` would convert.

    >>> import numpy as np
    >>> to_float(np.where(True, 0.0, 0.2))
    0.0
    """
    return math.ldexp(value, 0)


def to_number(value: object) -> float:
    """Return an argument as a ``float``. The result is NaN if it is no number, a bool, or too great.

    value: the argument.

    >>> to_number(2), to_number(True), to_number("2")
    (2.0, nan, nan)
    """
    try:
        return math.nan if isinstance(value, bool) else to_float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        return math.nan


class Wheels(NamedTuple):
    """A velocity in rad/s, or an angle in rad, for each of the two driven wheels.

    >>> wheels = Wheels(left=2.0, right=3.0)
    >>> wheels.right > wheels.left  # the robot turns to the left
    True
    >>> wheels
    Wheels(left=2, right=3)
    """

    left: float
    right: float

    def __repr__(self) -> str:
        return f"Wheels(left={_shorten(self.left)}, right={_shorten(self.right)})"


def _shorten(value: float) -> str:
    """Return a number with at most four decimals. Adding 0.0 turns -0.0 into 0.0."""
    try:
        return f"{round(value, 4) + 0.0:g}"
    except TypeError:
        return repr(value)  # An error message may show a value that is no number.


@dataclass(frozen=True, slots=True)
class DifferentialGeometry:
    """Converts between the wheel velocities and the twist of a robot with a differential drive.

    The formulas are v = r(ω_r + ω_l)/2 and ω = r(ω_r − ω_l)/track.
    Source: Siegwart, Introduction to Autonomous Mobile Robots, section 3.2.

    >>> from robotcore.geometry import Wheels
    >>> geometry = DifferentialGeometry(wheel_radius=0.05, track=0.2)
    >>> geometry.to_wheels(linear=0.1, angular=0.0)
    Wheels(left=2, right=2)
    >>> geometry.to_twist(Wheels(left=-1.0, right=1.0))
    Twist(linear=0 m/s, angular=0.5 rad/s)
    """

    wheel_radius: float
    """The radius of each wheel, in metres."""
    track: float
    """The distance between the centres of the two wheels, in metres."""

    def to_wheels(self, linear: float, angular: float) -> Wheels:
        """Return the wheel velocities in rad/s.

        linear: the forward velocity of the robot, in m/s.
        angular: the turn rate of the robot, in rad/s, positive to the left.
        """
        turn = angular * self.track / 2
        return Wheels((linear - turn) / self.wheel_radius, (linear + turn) / self.wheel_radius)

    def to_twist(self, wheels: Wheels) -> Twist:
        """Return the twist of the robot for wheel velocities in rad/s."""
        return Twist(*self.to_arc(*wheels))

    def to_arc(self, left: float, right: float) -> tuple[float, float]:
        """Return the length in metres and the turn in radians of the robot's arc.

        left, right: the angles in radians by which the wheels turn.
        """
        left, right = left * self.wheel_radius, right * self.wheel_radius
        return (left + right) / 2, (right - left) / self.track
