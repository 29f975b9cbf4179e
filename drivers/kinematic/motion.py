"""The motion of the wheels, which have a first-order lag, and of the body.

The motion is computed in closed form, without the error of a numerical integration. After a step of h seconds, a wheel
with the lag τ, the start velocity ω₀, the start angle φ₀ and the commanded velocity u has the velocity and the angle

    ω(h) = u + (ω₀ - u)·e^(-h/τ)        φ(h) = φ₀ + u·h + (ω₀ - u)·τ·(1 - e^(-h/τ))

In each step, the body moves along the circular arc that the turns of both wheels define.
"""

from __future__ import annotations

import math

from drivers.kinematic.clearance import CollisionChecker
from robotcore.geometry import DifferentialGeometry, Pose, Twist, Wheels


class Wheel:
    """A wheel with a motor. ``target`` is its commanded velocity and ``velocity`` its velocity, in rad/s.

    lag: the time constant of the motor, in seconds.
    step: the length of a simulation step, in seconds.

    >>> wheel = Wheel(lag=0.0, step=0.5)
    >>> wheel.target = 4.0
    >>> wheel.advance()
    >>> wheel.angle
    2.0
    """

    __slots__ = ("_decay", "_reach", "_step", "angle", "target", "velocity")

    def __init__(self, lag: float, step: float) -> None:
        self._step = step
        self._decay = math.exp(-step / lag) if lag else 0.0
        self._reach = -lag * math.expm1(-step / lag) if lag else 0.0
        self.target = self.velocity = self.angle = 0.0

    def next_turn(self) -> float:
        """Return the angle in rad by which the wheel turns in the next step if it does not stall."""
        return self.target * self._step + (self.velocity - self.target) * self._reach

    def roll(self, turn: float) -> None:
        """Make a step in which the wheel turns by ``turn`` rad."""
        self.velocity = self.target + (self.velocity - self.target) * self._decay
        self.angle += turn

    def stall(self) -> None:
        """Make a step in which the wheel does not turn."""
        self.velocity = 0.0

    def advance(self) -> None:
        """Make a step in which the wheel does not stall."""
        self.roll(self.next_turn())


class Chassis:
    """The body of a robot on the wheels of its drive. The wheels stall if the body would overlap another body."""

    def __init__(
        self, start: Pose, geometry: DifferentialGeometry, left: Wheel, right: Wheel, collisions: CollisionChecker
    ) -> None:
        self.pose = start
        self._geometry = geometry
        self._left, self._right = left, right
        self._collisions = collisions

    @property
    def twist(self) -> Twist:
        """The linear and the angular velocity of the body."""
        return self._geometry.to_twist(Wheels(self._left.velocity, self._right.velocity))

    def advance(self) -> None:
        """Advance the wheels and the body by one simulation step."""
        left, right = self._left.next_turn(), self._right.next_turn()
        distance, turn = self._geometry.to_twist(Wheels(left, right))
        there = self.pose.advance(distance, turn)
        if self._collisions.try_move(self.pose, there, abs(distance), abs(turn)):
            self.pose = there
            self._left.roll(left)
            self._right.roll(right)
        else:
            self._left.stall()
            self._right.stall()
