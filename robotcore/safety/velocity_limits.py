"""The rules that limit velocity and acceleration, and the record of a change of a command."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Protocol

from robotcore.geometry import Wheels

STOPPED = Wheels(0.0, 0.0)
"""The command that stops both wheels."""


@dataclass(frozen=True, slots=True)
class Intervention:
    """A record of a change of a command."""

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
    Wheels(left=10.0, right=-2.5)
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


@dataclass(frozen=True)
class AccelerationLimit:
    """A rule that limits the change of each wheel's velocity in a tick to ``change`` rad/s.

    It multiplies both changes by the same factor.

    >>> AccelerationLimit(2.0)(Wheels(9.0, 4.0), last=Wheels(1.0, 2.0))
    Wheels(left=3.0, right=2.5)
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
