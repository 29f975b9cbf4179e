"""Remote calls from the desk: an action's name and parameters come in, JSON text sequences (RFC 7464) go out."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from robotcore.deploy.agent.files import MAKE_ROOM, Layout

ACTIONS = {
    "probe": "push_actions:probe",
    "begin": "push_actions:begin_upload",
    "install": "push_actions:install_release",
    "discard": "push_actions:discard_upload",
    "activate": "run_actions:activate_release",
    "rollback": "run_actions:roll_back",
    "start": "run_actions:start_app",
    "stop": "run_actions:stop_app",
    "status": "run_actions:read_status",
    "logs": "run_actions:print_log",
    "releases": "admin_actions:list_releases",
    "recordings": "admin_actions:list_recordings",
    "erase": "admin_actions:erase_recordings",
    "remove": "admin_actions:remove_robotcore",
}
"""The module and the function of each action, by the action's name on the wire.

A function takes the layout and the desk's parameters by name. It returns a mapping that JSON can represent. Its module
is imported when the action is called, so that a call compiles only what it needs.
"""

Action = Callable[..., Mapping[str, Any]]


def answer_call(action: str, told: Mapping[str, Any], layout: Layout | None = None) -> int:
    """Do what the desk asks for, and write how it ended: ``done``, or ``refused``; return the exit status."""
    run = find_action(action)
    try:
        write_message({"done": run(layout or Layout(Path.home()), **told)})
    except AgentError as refusal:
        write_message({"refused": {"fault": refusal.fault, "remedy": refusal.remedy, "kind": refusal.kind}})
        return 1
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        write_message({"refused": {"fault": f"{where}{error.strerror}", "remedy": _build_remedy(error), "kind": "os"}})
        return 1
    return 0


def find_action(name: str) -> Action:
    """Return the function of an action, by its name on the wire; raises KeyError for an unknown name."""
    module, _, function = ACTIONS[name].partition(":")
    action: Action = getattr(import_module(f"robotcore.deploy.agent.{module}"), function)
    return action


def _build_remedy(error: OSError) -> str:
    """Return what to do about a failure of the system's."""
    import errno

    if error.errno in {errno.ENOSPC, errno.EDQUOT}:
        return MAKE_ROOM
    return "Look at it there"


MARK = "\x1e"
"""Begins each line that is ours."""

ReportProgress = Callable[..., None]
"""Tells the desk of progress: words, and whatever an action has to say besides, by name."""


class AgentError(Exception):
    """The robot cannot do what the desk asked for.

    fault: what happened, as a sentence without its full stop.
    remedy: what to do about it, as a sentence without its full stop.
    kind: a stable identifier of the fault. The desk chooses a better remedy for some kinds.
    fields: the values that the fault holds, by name. They stay on the robot.
    """

    def __init__(self, fault: str, remedy: str, kind: str, **fields: object) -> None:
        super().__init__(f"{fault}. {remedy}")
        self.fault, self.remedy, self.kind, self.fields = fault, remedy, kind, fields


def report_progress(words: str, **more: Any) -> None:
    """Tell of progress."""
    write_message({"say": words, **more})


def write_message(told: Any) -> None:
    """Write one line to the desk."""
    sys.stdout.write(f"{MARK}{json.dumps(told)}\n")
    sys.stdout.flush()
