"""Write a robot's behaviour once, prove it in simulation, run the very same file on the real robot.

What an app needs can be had from here; it is imported when it is first asked for, so that the command line starts fast.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robotcore.hal.robot import Robot as Robot
    from robotcore.hal.robot import Role as Role
    from robotcore.hal.truth import Truth as Truth
    from robotcore.runtime.behaviour import Behaviour as Behaviour
    from robotcore.runtime.behaviour import Status as Status
    from robotcore.runtime.behaviour import Stopping as Stopping
    from robotcore.runtime.plan import RunRequest as RunRequest
    from robotcore.runtime.result import Outcome as Outcome
    from robotcore.runtime.result import RunResult as RunResult
    from robotcore.runtime.session import run as run

_HOMES = {
    "Behaviour": "runtime.behaviour",
    "Outcome": "runtime.result",
    "Robot": "hal.robot",
    "Role": "hal.robot",
    "RunRequest": "runtime.plan",
    "RunResult": "runtime.result",
    "Status": "runtime.behaviour",
    "Stopping": "runtime.behaviour",
    "Truth": "hal.truth",
    "run": "runtime.session",
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
