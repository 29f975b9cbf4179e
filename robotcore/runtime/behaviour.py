"""The base class of apps: a behaviour decides once in each tick what the robot does."""

from __future__ import annotations

import atexit
import sys
from abc import ABC, abstractmethod
from collections.abc import Set as AbstractSet
from enum import Enum
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from robotcore.hal.robot import Robot
from robotcore.hal.truth import Truth
from robotcore.runtime.needs import Need

if TYPE_CHECKING:
    from typing_extensions import Self


class Status(Enum):
    """The result of a behaviour's step."""

    RUNNING = "running"
    SUCCESS = "success"
    FAILURE = "failure"


class Stopping(NamedTuple):
    """How an app stops in front of obstacles."""

    distance: float
    """The distance to the obstacle at which the app stops, in metres."""
    speed: float
    """The speed at which the app approaches an obstacle, in m/s."""


class Behaviour(ABC):
    """The base class of apps. An app decides once in each tick what a robot does.

    An app must not sleep, read the wall clock, read files or use a network. Make it a dataclass. The fields are then
    the app's settings (``--set speed_m_s=0.2``), and robotcore checks their types.
    """

    needs: ClassVar[AbstractSet[Need]] = frozenset()
    """The devices that the app requires: roles, names of devices, and classes of kinds, such as ``Role.DRIVE``,
    ``"rear"`` and ``Camera``. A run opens only the devices of ``needs`` and ``wants``."""
    wants: ClassVar[AbstractSet[Need]] = frozenset()
    """The devices that the app uses if the robot has them."""
    milestones: ClassVar[tuple[str, ...]] = ()
    """The states whose first time is recorded. A milestone is reached when ``state`` first equals its name."""
    state: str = "start"
    """The app's present state, such as ``search``. The trace contains it."""
    reason: str = ""
    """Why the app ended, for the result."""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        if cls.__module__ == "__main__" and hasattr(sys.modules["__main__"], "__file__"):  # not an interactive session
            atexit.unregister(_advise_to_run)
            atexit.register(_advise_to_run, cls.__name__, sys.argv[0])

    def __new__(cls, *_arguments: Any, **_settings: Any) -> Self:
        atexit.unregister(_advise_to_run)
        return super().__new__(cls)

    @abstractmethod
    def step(self, robot: Robot) -> Status:
        """Read sensors, command the drive, and return the status of the app. The loop calls this once in each tick."""

    @property
    def stopping(self) -> Stopping | None:
        """How the app stops in front of obstacles. None if it does not stop by itself.

        A run is refused if the range guard would stop the robot earlier.
        """
        return None

    def verify(self, truth: Truth) -> bool | None:
        """Return whether a run was a success, by the true state of the simulator at its end.

        Return None if this app cannot decide it.
        """
        return None


def _advise_to_run(app: str, file: str) -> None:
    """Write a note at the end of ``python my_app.py`` if the script defines an app, but creates none."""
    if sys.stderr and not hasattr(sys, "last_value"):  # an exception has not ended the script
        defined = vars(sys.modules["__main__"]).values()
        apps = [each for each in defined if isinstance(each, type) and each.__module__ == "__main__"]
        has_several = sum(issubclass(each, Behaviour) for each in apps) > 1
        name = f"{file}:{app}" if has_several else file
        sys.stderr.write(f"note: {file} defines the app {app}, but does not run it. Run it: robotcore run {name}\n")
