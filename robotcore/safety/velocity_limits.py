"""The rules that limit velocity and acceleration, and the record of a change of a command."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

from robotcore.geometry import Wheels

__all__ = ["Intervention"]

STOPPED = Wheels(0.0, 0.0)
"""The command that stops both wheels."""

NEGLIGIBLE = 1e-9
"""The relative difference of two velocities that is a rounding error."""


@dataclass(frozen=True, slots=True)
class Intervention:
    """A record of a change of a command.

    >>> from robotcore.geometry import Wheels
    >>> Intervention(time=1.25, cause="range guard", asked=Wheels(6.0, 6.0), sent=Wheels(0.0, 0.0)).cause
    'range guard'
    """

    time: float
    """The robot's time, in seconds."""
    cause: str
    """The rule that changed the command, or another cause such as ``deadman`` or ``e-stop``."""
    asked: Wheels
    """The command before the change, in rad/s."""
    sent: Wheels
    """The command after the change, in rad/s."""


class Rule(Protocol):
    """The interface of a safety rule. A rule returns a command unchanged, or a slower command."""

    @property
    def cause(self) -> str:
        """The name of the rule in interventions."""
        ...

    def __call__(self, command: Wheels, last: Wheels, /) -> Wheels:
        """Return the command that may be sent.

        command: the requested velocities, in rad/s.
        last: the velocities that were sent last, in rad/s.
        """
        ...


@dataclass(frozen=True)
class VelocityLimit:
    """A rule that limits each wheel to ``limit`` rad/s. It multiplies both velocities by the same factor.

    >>> limit = VelocityLimit(10.0)
    >>> limit(Wheels(20.0, -5.0), STOPPED)
    Wheels(left=10, right=-2.5)
    """

    cause: ClassVar = "velocity limit"

    limit: float

    def __call__(self, command: Wheels, last: Wheels) -> Wheels:
        left, right = command
        fastest = max(abs(left), abs(right))
        if fastest <= self.limit:
            return command
        scale = self.limit / fastest
        return Wheels(left * scale, right * scale)


class SteeringLimit:
    """A rule for a drive that steers. It makes a turn that is too sharp as sharp as possible, at the same speed.

    If the robot should turn on the spot, it stops.

    least, greatest: the limits of the ratio of the wheels' half difference to their mean, without a unit.

    >>> limit = SteeringLimit(-0.25, 0.25)
    >>> limit(Wheels(2.0, 6.0), STOPPED), limit.cause
    (Wheels(left=3, right=5), 'steering limit')
    >>> limit(Wheels(-2.0, 2.0), STOPPED), limit.cause
    (Wheels(left=0, right=0), 'turn on the spot')
    """

    def __init__(self, least: float, greatest: float) -> None:
        self._least, self._greatest = least, greatest
        self.cause = "steering limit"

    def __call__(self, command: Wheels, last: Wheels) -> Wheels:
        mean, half = (command.left + command.right) / 2, (command.right - command.left) / 2
        if abs(mean) <= NEGLIGIBLE * abs(half):
            self.cause = "turn on the spot"
            return STOPPED
        ratio = half / mean if mean else 0.0
        sharpest = max(self._least, min(ratio, self._greatest))
        if abs(ratio - sharpest) <= NEGLIGIBLE:
            return command
        self.cause = "steering limit"
        return Wheels(mean - sharpest * mean, mean + sharpest * mean)


@dataclass(frozen=True)
class AccelerationLimit:
    """A rule that limits the change of each wheel's velocity in a tick to ``change`` rad/s.

    It multiplies both changes by the same factor.

    >>> AccelerationLimit(2.0)(Wheels(9.0, 4.0), last=Wheels(1.0, 2.0))
    Wheels(left=3, right=2.5)
    """

    cause: ClassVar = "acceleration limit"

    change: float

    def __call__(self, command: Wheels, last: Wheels) -> Wheels:
        left, right = command.left - last.left, command.right - last.right
        largest = max(abs(left), abs(right))
        if largest <= self.change:
            return command
        scale = self.change / largest
        return Wheels(last.left + left * scale, last.right + right * scale)


@dataclass(frozen=True)
class ArcAccelerationLimit:
    """A rule that limits the change of the mean velocity in a tick to ``change`` rad/s, for a drive that steers.

    The robot brakes to a stop or a reversal on its last arc. Otherwise it drives on the arc of the new command.

    >>> ArcAccelerationLimit(2.0)(Wheels(9.0, 7.0), last=Wheels(1.0, 3.0))
    Wheels(left=4.5, right=3.5)
    """

    cause: ClassVar = AccelerationLimit.cause

    change: float

    def __call__(self, command: Wheels, last: Wheels) -> Wheels:
        wanted, before = (command.left + command.right) / 2, (last.left + last.right) / 2
        if abs(wanted - before) <= self.change:
            return command
        mean = before + math.copysign(self.change, wanted - before)
        arc, speed = (command, wanted) if mean * wanted > 0 else (last, before)
        return Wheels(mean * (arc.left / speed), mean * (arc.right / speed))
