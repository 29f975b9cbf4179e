"""How the robot moves: wheels with a first-order lag, and the exact arc that two of them make.

Nothing is integrated numerically. Over a step of h seconds a wheel of lag τ on its way to the velocity u has

    ω(h) = u + (ω₀ - u)·e^(-h/τ)        φ(h) = φ₀ + u·h + (ω₀ - u)·τ·(1 - e^(-h/τ))

and the body follows the arc of those angles. While both velocities keep their proportion, any number of
steps gives the same place as one.
"""

from __future__ import annotations

import math

from drivers.kinematic.clearance import Bumper
from robotcore.geometry import DifferentialGeometry, Pose, Twist, Wheels


class Wheel:
    """A motor and its wheel: ``velocity`` in rad/s lags behind ``target``; ``angle`` is in rad.

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
        """Return by how much the wheel would turn in the next step, in rad."""
        return self.target * self._step + (self.velocity - self.target) * self._reach

    def roll(self, turn: float) -> None:
        """Take the step, in which it turns by ``turn``."""
        self.velocity = self.target + (self.velocity - self.target) * self._decay
        self.angle += turn

    def stall(self) -> None:
        """Take the step without turning."""
        self.velocity = 0.0

    def advance(self) -> None:
        """Take the step, running free."""
        self.roll(self.next_turn())


class Chassis:
    """A body on two wheels. A step that would drive it into something is not made: the wheels stall."""

    def __init__(self, start: Pose, geometry: DifferentialGeometry, left: Wheel, right: Wheel, bumper: Bumper) -> None:
        self.pose = start
        self._geometry = geometry
        self._left, self._right = left, right
        self._bumper = bumper

    @property
    def twist(self) -> Twist:
        """How the body moves at this instant."""
        return self._geometry.to_twist(Wheels(self._left.velocity, self._right.velocity))

    def advance(self) -> None:
        """Take one step."""
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
