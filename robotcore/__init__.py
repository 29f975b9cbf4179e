"""Write a robot's behaviour once, prove it in simulation, run the very same file on the real robot.

What an app needs can be had from here; it is imported when it is first asked for, so that the command line starts fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robotcore.behaviour import Behaviour as Behaviour
    from robotcore.behaviour import Status as Status
    from robotcore.behaviour import Stopping as Stopping
    from robotcore.robot import Robot as Robot
    from robotcore.robot import Role as Role
    from robotcore.running.outcome import Outcome as Outcome
    from robotcore.running.outcome import RunResult as RunResult
    from robotcore.running.plan import RunRequest as RunRequest
    from robotcore.running.session import run as run
    from robotcore.truth import Truth as Truth

_HOMES = {
    "Behaviour": "behaviour",
    "Outcome": "running.outcome",
    "Robot": "robot",
    "Role": "robot",
    "RunRequest": "running.plan",
    "RunResult": "running.outcome",
    "Status": "behaviour",
    "Stopping": "behaviour",
    "Truth": "truth",
    "run": "running.session",
}

__all__ = [
    "Behaviour",
    "Outcome",
    "Robot",
    "Role",
    "RunRequest",
    "RunResult",
    "Status",
    "Stopping",
    "Truth",
    "run",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'robotcore' has no attribute {name!r}")
    return getattr(import_module(f"robotcore.{_HOMES[name]}"), name)
