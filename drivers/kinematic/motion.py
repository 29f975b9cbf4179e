"""The motion of the wheels, which have a first-order lag, and of the body.

The motion is computed in closed form, without the error of a numerical integration. After a step of h seconds, a wheel
with the lag τ, the start velocity ω₀, the start angle φ₀ and the commanded velocity u has the velocity and the angle

    ω(h) = u + (ω₀ - u)·e^(-h/τ)        φ(h) = φ₀ + u·h + (ω₀ - u)·τ·(1 - e^(-h/τ))

In each step, the body moves along the circular arc that the turns of both wheels define.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from drivers.kinematic.clearance import CollisionChecker
from robotcore.geometry import DifferentialGeometry, Pose, Twist, Wheels
from robotcore.hal.clock import SteppedClock
from robotcore.hal.joint import Joint


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


class SideWheels:
    """The wheels on one side of a robot that skids. The side moves by the mean of their turns."""

    def __init__(self, wheels: Sequence[Wheel]) -> None:
        self._wheels = tuple(wheels)
        self._turns: list[float] = []

    @property
    def velocity(self) -> float:
        """The mean velocity of the wheels, in rad/s."""
        return sum(wheel.velocity for wheel in self._wheels) / len(self._wheels)

    def next_turn(self) -> float:
        """Return the mean angle in rad by which the wheels turn in the next step if they do not stall."""
        self._turns = [wheel.next_turn() for wheel in self._wheels]
        return sum(self._turns) / len(self._turns)

    def roll(self, _turn: float) -> None:
        """Make a step in which each wheel turns by its own angle."""
        for wheel, turn in zip(self._wheels, self._turns, strict=True):
            wheel.roll(turn)

    def stall(self) -> None:
        """Make a step in which no wheel turns."""
        for wheel in self._wheels:
            wheel.stall()


class Chassis:
    """The body of a robot on the wheels of its drive. The wheels stall if the body would overlap another body."""

    def __init__(
        self,
        start: Pose,
        geometry: DifferentialGeometry,
        left: Wheel | SideWheels,
        right: Wheel | SideWheels,
        collisions: CollisionChecker,
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
        distance, turn = self._geometry.to_arc(left, right)
        there = self.pose.advance(distance, turn)
        if self._collisions.try_move(self.pose, there, abs(distance), abs(turn)):
            self.pose = there
            self._left.roll(left)
            self._right.roll(right)
        else:
            self._left.stall()
            self._right.stall()


class SteeredChassis(Chassis):
    """The body of a robot that steers, on its rear wheels. No wheel skids.

    The mean of the wheels' turns is that of the motors. The steering angle defines the difference.

    left, right: the wheels of the motors; the same for one motor of both wheels.
    joint: the motion of the servo that steers.
    ratio: half of the distance between the rear wheels, divided by the distance between the axles.
    """

    def __init__(
        self,
        start: Pose,
        geometry: DifferentialGeometry,
        left: Wheel,
        right: Wheel,
        collisions: CollisionChecker,
        joint: Joint,
        ratio: float,
        clock: SteppedClock,
    ) -> None:
        super().__init__(start, geometry, left, right, collisions)
        self._wheels = [(left, 0.0)] if left is right else [(left, -1.0), (right, 1.0)]
        self._joint, self._ratio, self._rate = joint, ratio, clock.steps_per_second
        self._steps = 0

    @property
    def twist(self) -> Twist:
        velocity = sum(wheel.velocity for wheel, _ in self._wheels) / len(self._wheels)
        shift = velocity * self._ratio * math.tan(self._joint.angle_at(self._steps / self._rate))
        return self._geometry.to_twist(Wheels(velocity - shift, velocity + shift))

    def advance(self) -> None:
        since, until = self._steps / self._rate, (self._steps + 1) / self._rate
        self._steps += 1
        mean = sum(wheel.next_turn() for wheel, _ in self._wheels) / len(self._wheels)
        shift = mean * self._ratio * self._joint.mean_tangent(since, until)
        distance, turn = self._geometry.to_arc(mean - shift, mean + shift)
        there = self.pose.advance(distance, turn)
        if self._collisions.try_move(self.pose, there, abs(distance), abs(turn)):
            self.pose = there
            for wheel, side in self._wheels:
                wheel.roll(mean + side * shift)
        else:
            for wheel, _ in self._wheels:
                wheel.stall()
