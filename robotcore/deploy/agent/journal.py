"""Reads the app's output from systemd's journal."""

from __future__ import annotations

import json
import os
import re
import subprocess
import time
from collections.abc import Sequence
from itertools import dropwhile, islice, takewhile

from robotcore.deploy.agent import robot_facts
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.systemctl import EXITED, KILLED, UnitState

LAST_LINES = 12
"""The number of the app's last lines that a failure report has: an error message, or the end of a traceback."""

_READ_LINES = 300
"""The greatest number of lines read. Python's dump of an aborted process has several lines for each thread."""

_ABORTED = "Fatal Python error: "
_DUMP_LINE = re.compile(r'(Current thread|Thread) 0x|  File "|  \.\.\.|  <|Extension modules: ')
_CURRENT_THREAD = "Current thread 0x"
_FRAMES_KEPT = 5
"""The number of frames kept of a dump by Python's faulthandler. The innermost frame comes first."""

_EXIT_MESSAGE_ID = "98e322203f7a4ed290d09fe03c09fe15"
"""systemd's identifier of the message that a main process has ended. Source: systemd, sd-messages.h."""

_TRIES, _RETRY_S = 5, 0.2
"""The number of attempts to read, and the pause between them in s.

The journal receives the last lines of a process only after the end of the process.
"""

_COMMAND = ("journalctl", "--no-pager")

_UNREADABLE_TEXTS = ("insufficient permissions", "No journal files were found")


def read_last_lines(unit: str, invocation: str, count: int = LAST_LINES) -> tuple[str, ...]:
    """Return the last lines that the processes of a unit printed in one invocation, without systemd's messages."""
    matches = [f"_SYSTEMD_USER_UNIT={unit}", f"_SYSTEMD_INVOCATION_ID={invocation}", f"_UID={os.getuid()}"]
    for _ in range(_TRIES):
        done = _run_journalctl("--output=cat", f"--lines={_READ_LINES}", *matches)
        if any(text in done.stderr for text in _UNREADABLE_TEXTS):
            return (f"(this user may not read its output. On the robot: {_build_remedy()})",)
        if lines := [_strip_control(line) for line in done.stdout.splitlines() if line.strip()]:
            return tuple(_shorten_dump(lines)[-count:])
        time.sleep(_RETRY_S)
    return ()


def _shorten_dump(lines: Sequence[str]) -> list[str]:
    aborted = [number for number, line in enumerate(lines) if line.startswith(_ABORTED)]
    if not aborted:
        return list(lines)
    begin = aborted[-1] + 1
    dump = list(takewhile(_DUMP_LINE.match, lines[begin:]))
    current = dropwhile(lambda line: not line.startswith(_CURRENT_THREAD), dump)
    return [*lines[:begin], *islice(current, 1 + _FRAMES_KEPT), *lines[begin + len(dump) :]]


def read_last_end(unit: str) -> tuple[str, str] | None:
    """Return the cause of the last failure of a unit's main process, in words, and the identifier of its invocation.

    Return None if the process never failed.
    """
    fields = "--output-fields=EXIT_CODE,EXIT_STATUS,USER_INVOCATION_ID"
    matches = (f"MESSAGE_ID={_EXIT_MESSAGE_ID}", f"USER_UNIT={unit}", f"_UID={os.getuid()}")
    try:
        entry = json.loads(_run_journalctl("--output=json", fields, "--lines=1", *matches).stdout)
        how, status, invocation = entry["EXIT_CODE"], entry["EXIT_STATUS"], entry["USER_INVOCATION_ID"]
        reason = UnitState(code=EXITED if how == "exited" else KILLED, status=int(status)).describe_end()
    except (ValueError, KeyError):
        return None
    return reason, invocation


def print_lines(unit: str, count: int, *, is_followed: bool) -> None:
    """Print the last lines of a unit's journal.

    The function selects lines by the unit's name, because all users of Raspberry Pi OS share one journal in memory.

    count: the number of lines.
    is_followed: whether to print new lines too, until the client closes the connection.
    Raises AgentError if the journal cannot be read.
    """
    command = [*_COMMAND, "--quiet", "--output=short-iso", f"--lines={count}", f"--user-unit={unit}"]
    status = subprocess.run([*command, *(["--follow"] if is_followed else [])], check=False).returncode  # noqa: S603
    if status > 0:
        raise AgentError("the journal cannot be read", f"On the robot: {_build_remedy()}", "journal")


def _run_journalctl(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(  # noqa: S603 - constants, and systemd's own identifiers
        (*_COMMAND, *arguments), capture_output=True, text=True, errors="replace", check=False
    )


def _build_remedy() -> str:
    return f"sudo usermod -aG systemd-journal {robot_facts.read_user()}, and log in again"


def _strip_control(line: str) -> str:
    return "".join(each for each in line.expandtabs(4) if each.isprintable())
