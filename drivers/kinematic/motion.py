"""The robot's motion: wheels with a first-order lag, and the exact arc of the body.

Nothing is integrated numerically. After a step of h seconds, a wheel with the lag τ and the command u has

    ω(h) = u + (ω₀ - u)·e^(-h/τ)        φ(h) = φ₀ + u·h + (ω₀ - u)·τ·(1 - e^(-h/τ))

and the body follows the arc of these angles. While the ratio of the velocities is constant, any number of
steps gives the same pose as one.
"""

from __future__ import annotations

import math

from drivers.kinematic.clearance import Bumper
from robotcore.geometry import DifferentialGeometry, Pose, Twist, Wheels


class Wheel:
    """A motor and its wheel.

    ``target`` is the commanded velocity and ``velocity`` the actual one, in rad/s. ``angle`` is in rad.

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
        """Return the turn of a free wheel in the next step, in rad."""
        return self.target * self._step + (self.velocity - self.target) * self._reach

    def roll(self, turn: float) -> None:
        """Make a step with this turn in rad."""
        self.velocity = self.target + (self.velocity - self.target) * self._decay
        self.angle += turn

    def stall(self) -> None:
        """Make a step without a turn."""
        self.velocity = 0.0

    def advance(self) -> None:
        """Make a step of a free wheel."""
        self.roll(self.next_turn())


class Chassis:
    """A body on two wheels. If a step would cause an overlap, the wheels stall."""

    def __init__(self, start: Pose, geometry: DifferentialGeometry, left: Wheel, right: Wheel, bumper: Bumper) -> None:
        self.pose = start
        self._geometry = geometry
        self._left, self._right = left, right
        self._bumper = bumper

    @property
    def twist(self) -> Twist:
        """The present velocity of the body."""
        return self._geometry.to_twist(Wheels(self._left.velocity, self._right.velocity))

    def advance(self) -> None:
        """Make one step."""
        left, right = self._left.next_turn(), self._right.next_turn()
        distance, turn = self._geometry.to_twist(Wheels(left, right))
        there = self.pose.advanced(distance, turn)
        if self._bumper.permits(self.pose, there, abs(distance), abs(turn)):
            self.pose = there
            self._left.roll(left)
            self._right.roll(right)
        else:
            self._left.stall()
            self._right.stall()
