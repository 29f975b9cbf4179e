"""What the app wrote, as systemd's journal has it."""

from __future__ import annotations

import os
import subprocess
import time

from robotcore.deploy.aboard.system import session
from robotcore.deploy.aboard.telling import RefusalError

LAST = 12
"""Lines of an app that tell why it ended: an error in words, or the end of a traceback."""

_TRIES, _LOOK_S = 5, 0.2
"""The journal has a process's last words a moment after its end."""

_COMMAND = ("journalctl", "--no-pager")

_UNREADABLE = ("insufficient permissions", "No journal files were found")


def last_lines(unit: str, invocation: str, count: int = LAST) -> tuple[str, ...]:
    """Return what a unit's own processes wrote last while it was started once, without what systemd says of it."""
    matches = [f"_SYSTEMD_USER_UNIT={unit}", f"_SYSTEMD_INVOCATION_ID={invocation}", f"_UID={os.getuid()}"]
    for _ in range(_TRIES):
        done = _journalctl("--output=cat", f"--lines={count}", *matches)
        if any(words in done.stderr for words in _UNREADABLE):
            return (f"(nobody may read what it wrote. On the robot: {_remedy()})",)
        if lines := [_plain(line) for line in done.stdout.splitlines() if line.strip()]:
            return tuple(lines[-count:])
        time.sleep(_LOOK_S)
    return ()


def show(unit: str, count: int, *, is_followed: bool) -> None:
    """Print what was written by a unit, and of it, until the reader has gone where it is followed; raises RefusalError.

    The journal is asked by the unit's name, not as the user's own one: where it is not kept on disk, as on Raspberry
    Pi OS, there is one for all.
    """
    command = [*_COMMAND, "--quiet", "--output=short-iso", f"--lines={count}", f"--user-unit={unit}"]
    status = subprocess.run([*command, *(["--follow"] if is_followed else [])], check=False).returncode  # noqa: S603
    if status > 0:
        raise RefusalError("the journal cannot be read", f"On the robot: {_remedy()}", "journal")


def _journalctl(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(  # noqa: S603 - constants, and what systemd told
        (*_COMMAND, *arguments), capture_output=True, text=True, errors="replace", check=False
    )


def _remedy() -> str:
    return f"sudo usermod -aG systemd-journal {session.user()}, and log in again"


def _plain(line: str) -> str:
    """Return a line without what would move a terminal's cursor."""
    return "".join(each for each in line.expandtabs(4) if each.isprintable())
