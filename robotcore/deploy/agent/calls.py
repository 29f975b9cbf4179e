"""Takes one call of the desk's: an action by name, with what it is told, and how it ended."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from robotcore.deploy.agent.layout import Layout
from robotcore.deploy.agent.system.disk import MAKE_ROOM
from robotcore.deploy.agent.telling import RefusalError, write

ACTIONS = (
    "probe",
    "begin",
    "discard",
    "install",
    "activate",
    "releases",
    "rollback",
    "status",
    "logs",
    "start",
    "stop",
    "remove",
    "recordings",
    "erase",
)
"""Each is the function ``act`` of the module of its name in ``actions``: it takes the layout and what it is told by
name, and returns what JSON can tell."""

Action = Callable[..., Mapping[str, Any]]


def answer(action: str, told: Mapping[str, Any], layout: Layout | None = None) -> int:
    """Do what the desk asks for, and write how it ended: ``done``, or ``refused``; return the exit status."""
    act: Action = import_module(f"robotcore.deploy.agent.actions.{action}").act
    try:
        write({"done": act(layout or Layout(Path.home()), **told)})
    except RefusalError as refusal:
        write({"refused": {"fault": refusal.fault, "remedy": refusal.remedy, "kind": refusal.kind}})
        return 1
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        write({"refused": {"fault": f"{where}{error.strerror}", "remedy": _remedy(error), "kind": "os"}})
        return 1
    return 0


def _remedy(error: OSError) -> str:
    """Return what to do about a failure of the system's."""
    import errno

    if error.errno in {errno.ENOSPC, errno.EDQUOT}:
        return MAKE_ROOM
    return "Look at it there"
