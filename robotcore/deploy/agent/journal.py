"""The app's output, read from systemd's journal."""

from __future__ import annotations

import json
import os
import re
import subprocess
import time
from collections.abc import Sequence
from itertools import dropwhile, islice, takewhile

from robotcore.deploy.agent import robot_facts
from robotcore.deploy.agent.rpc import AgentError
from robotcore.deploy.agent.systemd import EXITED, KILLED, UnitState

LAST_LINES = 12
"""Lines of an app that tell why it ended: an error in words, or the end of a traceback."""

_READ_LINES = 300
"""Lines that are read for them: what Python dumps as it is aborted has some for each thread."""

_ABORTED = "Fatal Python error: "
_DUMP_LINE = re.compile(r'(Current thread|Thread) 0x|  File "|  \.\.\.|  <|Extension modules: ')
_CURRENT_THREAD = "Current thread 0x"
_FRAMES_KEPT = 5
"""How Python's faulthandler tells what each thread did, the innermost frame first, and how many of those are told."""

_EXIT_MESSAGE_ID = "98e322203f7a4ed290d09fe03c09fe15"
"""How systemd marks what it says of a main process that has ended. Source: systemd, sd-messages.h."""

_TRIES, _RETRY_S = 5, 0.2
"""The journal has a process's last words a moment after its end."""

_COMMAND = ("journalctl", "--no-pager")

_UNREADABLE_TEXTS = ("insufficient permissions", "No journal files were found")


def read_last_lines(unit: str, invocation: str, count: int = LAST_LINES) -> tuple[str, ...]:
    """Return what a unit's own processes wrote last while it was started once, without what systemd says of it."""
    matches = [f"_SYSTEMD_USER_UNIT={unit}", f"_SYSTEMD_INVOCATION_ID={invocation}", f"_UID={os.getuid()}"]
    for _ in range(_TRIES):
        done = _run_journalctl("--output=cat", f"--lines={_READ_LINES}", *matches)
        if any(words in done.stderr for words in _UNREADABLE_TEXTS):
            return (f"(nobody may read what it wrote. On the robot: {_build_remedy()})",)
        if lines := [_strip_control(line) for line in done.stdout.splitlines() if line.strip()]:
            return tuple(_shorten_dump(lines)[-count:])
        time.sleep(_RETRY_S)
    return ()


def _shorten_dump(lines: Sequence[str]) -> list[str]:
    """Return lines with no more of a dump of Python's than where the thread was that was aborted."""
    aborted = [number for number, line in enumerate(lines) if line.startswith(_ABORTED)]
    if not aborted:
        return list(lines)
    begin = aborted[-1] + 1
    dump = list(takewhile(_DUMP_LINE.match, lines[begin:]))
    current = dropwhile(lambda line: not line.startswith(_CURRENT_THREAD), dump)
    return [*lines[:begin], *islice(current, 1 + _FRAMES_KEPT), *lines[begin + len(dump) :]]


def read_last_end(unit: str) -> tuple[str, str] | None:
    """Return how a unit's main process ended last, if it did so badly, in words, and the invocation that was."""
    fields = "--output-fields=EXIT_CODE,EXIT_STATUS,USER_INVOCATION_ID"
    matches = (f"MESSAGE_ID={_EXIT_MESSAGE_ID}", f"USER_UNIT={unit}", f"_UID={os.getuid()}")
    try:
        told = json.loads(_run_journalctl("--output=json", fields, "--lines=1", *matches).stdout)
        how, status, invocation = told["EXIT_CODE"], told["EXIT_STATUS"], told["USER_INVOCATION_ID"]
        reason = UnitState(code=EXITED if how == "exited" else KILLED, status=int(status)).ending()
    except (ValueError, KeyError):
        return None
    return reason, invocation


def print_lines(unit: str, count: int, *, is_followed: bool) -> None:
    """Print what was written by a unit, and of it, until the reader has gone where it is followed; raises RefusalError.

    The journal is asked by the unit's name, not as the user's own one: where it is not kept on disk, as on Raspberry
    Pi OS, there is one for all.
    """
    command = [*_COMMAND, "--quiet", "--output=short-iso", f"--lines={count}", f"--user-unit={unit}"]
    status = subprocess.run([*command, *(["--follow"] if is_followed else [])], check=False).returncode  # noqa: S603
    if status > 0:
        raise AgentError("the journal cannot be read", f"On the robot: {_build_remedy()}", "journal")


def _run_journalctl(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(  # noqa: S603 - constants, and what systemd told
        (*_COMMAND, *arguments), capture_output=True, text=True, errors="replace", check=False
    )


def _build_remedy() -> str:
    return f"sudo usermod -aG systemd-journal {robot_facts.read_user()}, and log in again"


def _strip_control(line: str) -> str:
    """Return a line without what would move a terminal's cursor."""
    return "".join(each for each in line.expandtabs(4) if each.isprintable())
