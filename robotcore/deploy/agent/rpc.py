"""Answers remote calls from the client.

A call has the name and the parameters of an action. The answer is a JSON text sequence (RFC 7464).
"""

from __future__ import annotations

import errno
import json
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from robotcore.deploy.agent.errors import MAKE_ROOM, AgentError
from robotcore.deploy.agent.files import Layout

MARK = "\x1e"
"""The first character of each message. It distinguishes a message from lines that a login shell prints."""

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


def answer_call(action: str, parameters: Mapping[str, Any]) -> int:
    """Run an action, send its result to the client as the message ``done`` or ``refused``, and return the exit status.

    action: the action's name in the protocol.
    parameters: the action's parameters by name.
    """
    module, _, function = ACTIONS[action].partition(":")
    run: Callable[..., Mapping[str, Any]] = getattr(import_module(f"robotcore.deploy.agent.{module}"), function)
    try:
        write_message({"done": run(Layout(Path.home()), **parameters)})
    except AgentError as error:
        write_message({"refused": {"problem": error.problem, "remedy": error.remedy, "kind": error.kind}})
        return 1
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        is_full = error.errno in {errno.ENOSPC, errno.EDQUOT}
        remedy = MAKE_ROOM if is_full else "Log in to the robot, and check its disk and the permissions of its files"
        write_message({"refused": {"problem": f"{where}{error.strerror}", "remedy": remedy, "kind": "os"}})
        return 1
    return 0


def report_progress(text: str, **more: Any) -> None:
    """Report the current activity to the client, in words, with further fields of the message by name."""
    write_message({"text": text, **more})


def write_message(message: Any) -> None:
    """Write one message to the client, as a line of JSON."""
    sys.stdout.write(f"{MARK}{json.dumps(message)}\n")
    sys.stdout.flush()
