"""What an app is: a behaviour that decides once a tick."""

from __future__ import annotations

from abc import ABC, abstractmethod
from enum import Enum
from typing import ClassVar, NamedTuple

from robotcore.hal.robot import Robot, Role
from robotcore.hal.truth import Truth


class Status(Enum):
    """What a behaviour says at the end of a tick."""

    RUNNING = "running"
    SUCCESS = "success"
    FAILURE = "failure"


class Stopping(NamedTuple):
    """Where an app means to stop in front of things, and how fast it comes; metres and m/s."""

    distance: float
    speed: float


class Behaviour(ABC):
    """Decides, once a tick, what a robot does. Never sleeps, never looks at wall time, does no I/O.

    Make it a dataclass: its fields are the app's settings (``--set speed_m_s=0.2``), checked by their types. Only the
    roles in ``needs`` are opened, and those in ``wants`` where the robot has them. The first time that ``state`` takes
    the name of a milestone, the milestone is reached.
    """

    needs: ClassVar[frozenset[Role]] = frozenset()
    wants: ClassVar[frozenset[Role]] = frozenset()
    milestones: ClassVar[tuple[str, ...]] = ()
    state: str = "start"
    reason: str = ""

    @abstractmethod
    def step(self, robot: Robot) -> Status:
        """Read what is needed, command the drive, say how it stands."""

    @property
    def stopping(self) -> Stopping | None:
        """Where the app stops in front of things, if it does: the range guard must act nearer than that."""
        return None

    def verify(self, truth: Truth) -> bool | None:
        """Judge the end of a run by the simulator's truth; None where there is nothing to judge."""
        return None
