"""Answers remote calls from the client.

A call has the name and the parameters of an action. The answer is a JSON text sequence (RFC 7464).
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from robotcore.deploy.agent.files import MAKE_ROOM, Layout

MARK = "\x1e"
"""The first character of each message. It distinguishes a message from lines that a login shell prints."""

ReportProgress = Callable[..., None]
"""A function that reports progress to the client, see `report_progress`."""

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
"""The module and the function of each action, by the action's name in the protocol.

The function takes the layout, and the client's parameters by name. It returns a mapping that JSON can represent. Its
module is imported during the call, so that a call compiles only the modules that it needs.
"""

Action = Callable[..., Mapping[str, Any]]


def answer_call(action: str, parameters: Mapping[str, Any], layout: Layout | None = None) -> int:
    """Run an action, send its result to the client as the message ``done`` or ``refused``, and return the exit status.

    action: the action's name in the protocol.
    parameters: the action's parameters by name.
    layout: the folders of the robot; by default those in the user's home.
    """
    run = find_action(action)
    try:
        write_message({"done": run(layout or Layout(Path.home()), **parameters)})
    except AgentError as error:
        write_message({"refused": {"fault": error.problem, "remedy": error.remedy, "kind": error.kind}})
        return 1
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        write_message({"refused": {"fault": f"{where}{error.strerror}", "remedy": _build_remedy(error), "kind": "os"}})
        return 1
    return 0


def find_action(name: str) -> Action:
    """Return the function of an action. Raises KeyError for an unknown name."""
    module, _, function = ACTIONS[name].partition(":")
    action: Action = getattr(import_module(f"robotcore.deploy.agent.{module}"), function)
    return action


def _build_remedy(error: OSError) -> str:
    import errno

    if error.errno in {errno.ENOSPC, errno.EDQUOT}:
        return MAKE_ROOM
    return "Log in to the robot, and check its disk and the permissions of its files"


class AgentError(Exception):
    """Raised if the robot cannot do the action.

    problem: the cause, as a sentence without its full stop.
    remedy: what the user can do, as a sentence without its full stop.
    kind: a stable identifier of the problem. The client chooses a better remedy for some kinds.
    fields: the values in the text of the problem, by name. They are not sent to the client.
    """

    def __init__(self, problem: str, remedy: str, kind: str, **fields: object) -> None:
        super().__init__(f"{problem}. {remedy}")
        self.problem, self.remedy, self.kind, self.fields = problem, remedy, kind, fields


def report_progress(text: str, **more: Any) -> None:
    """Report the current activity to the client, in words, with further fields of the message by name."""
    write_message({"say": text, **more})


def write_message(message: Any) -> None:
    """Write one message to the client, as a line of JSON."""
    sys.stdout.write(f"{MARK}{json.dumps(message)}\n")
    sys.stdout.flush()
