"""The base class of apps: a behaviour that decides once in each tick."""

from __future__ import annotations

from abc import ABC, abstractmethod
from enum import Enum
from typing import ClassVar, NamedTuple

from robotcore.hal.robot import Robot, Role
from robotcore.hal.truth import Truth


class Status(Enum):
    """The result of a behaviour's step."""

    RUNNING = "running"
    SUCCESS = "success"
    FAILURE = "failure"


class Stopping(NamedTuple):
    """Where and from which speed an app stops in front of obstacles."""

    distance: float
    """The distance at which it stops, in metres."""
    speed: float
    """Its speed of approach, in m/s."""


class Behaviour(ABC):
    """Decides once in each tick what a robot does. It never sleeps, never reads the wall clock, and does no I/O.

    Make it a dataclass: its fields are the app's settings (``--set speed_m_s=0.2``), and their types are checked.
    """

    needs: ClassVar[frozenset[Role]] = frozenset()
    """The roles that the app cannot do without. No other devices are opened."""
    wants: ClassVar[frozenset[Role]] = frozenset()
    """The roles that are opened too, if the robot has them."""
    milestones: ClassVar[tuple[str, ...]] = ()
    """Names of states. A milestone is reached when ``state`` has its name for the first time."""
    state: str = "start"
    """The app's present state, for people and for the trace."""
    reason: str = ""
    """Why the app ended, for the result."""

    @abstractmethod
    def step(self, robot: Robot) -> Status:
        """Read sensors, command the drive, and return whether the app goes on. Called once in each tick."""

    @property
    def stopping(self) -> Stopping | None:
        """Where the app stops in front of obstacles; None if it does not. The range guard must act at less distance."""
        return None

    def verify(self, truth: Truth) -> bool | None:
        """Return whether the simulator's truth at the end of a run shows a success; None if this app cannot say."""
        return None
