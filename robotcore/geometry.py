"""Plane geometry: poses, twists, and the exact motion of a rigid body.

Robot frame: x forward, y left, z up; a turn to the left is positive (REP 103).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple


class Twist(NamedTuple):
    """A velocity in the plane: ``linear`` forward in m/s, ``angular`` to the left in rad/s."""

    linear: float
    angular: float


class Pose(NamedTuple):
    """A place in the plane, in metres, and a heading in radians."""

    x: float
    y: float
    heading: float

    def advanced(self, distance: float, turn: float) -> Pose:
        """Return the pose after an arc of constant curvature.

        The chord of an arc of length s that turns by a is s·sinc(a/2), along heading + a/2.
        """
        half = turn / 2
        chord = distance * (math.sin(half) / half if abs(half) > 1e-12 else 1.0)
        middle = self.heading + half
        return Pose(
            self.x + chord * math.cos(middle),
            self.y + chord * math.sin(middle),
            self.heading + turn,
        )

    def moved(self, by: Pose) -> Pose:
        """Return the pose, in the world, of something that sits at ``by`` in this pose's frame."""
        return Pose(*self.to_world(by.x, by.y), self.heading + by.heading)

    def to_world(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of this pose's frame lies in the world."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return self.x + x * cos - y * sin, self.y + x * sin + y * cos

    def to_local(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the world lies in this pose's frame."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        dx, dy = x - self.x, y - self.y
        return dx * cos + dy * sin, dy * cos - dx * sin

    def distance_to(self, x: float, y: float) -> float:
        """Return the distance to a point, in metres."""
        return math.hypot(x - self.x, y - self.y)

    def bearing_to(self, x: float, y: float) -> float:
        """Return the direction of a point as seen from here, in (-π, π], positive to the left."""
        return wrap_angle(math.atan2(y - self.y, x - self.x) - self.heading)


def wrap_angle(angle: float) -> float:
    """Return the same direction in (-π, π]."""
    wrapped = math.remainder(angle, math.tau)
    return math.pi if wrapped == -math.pi else wrapped


def to_float(value: float) -> float:
    """Return a copy of a real number as a float: an element of a NumPy array may change after the call.

    Raises TypeError for text, which ``float`` would read.

    >>> import numpy as np
    >>> to_float(np.where(True, 0.0, 0.2))
    0.0
    """
    return math.ldexp(value, 0)


class Wheels(NamedTuple):
    """Something of both wheels: their velocities in rad/s, or their angles in rad."""

    left: float
    right: float


@dataclass(frozen=True, slots=True)
class DifferentialGeometry:
    """The two lengths that relate wheels and body, in metres.

    v = r(ω_r + ω_l)/2 and ω = r(ω_r − ω_l)/track: Siegwart, Introduction to Autonomous Mobile Robots, 3.2.
    """

    wheel_radius: float
    track: float

    def to_wheels(self, linear: float, angular: float) -> Wheels:
        """Return the wheel velocities that make the body move so."""
        turn = angular * self.track / 2
        return Wheels((linear - turn) / self.wheel_radius, (linear + turn) / self.wheel_radius)

    def to_twist(self, wheels: Wheels) -> Twist:
        """Return how the body moves with these wheel velocities."""
        left, right = wheels.left * self.wheel_radius, wheels.right * self.wheel_radius
        return Twist((left + right) / 2, (right - left) / self.track)
