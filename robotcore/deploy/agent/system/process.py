"""A process by what no other one shares with it, so that it is known whether it still lives, a reboot later too."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

_PROC = Path("/proc")
_BOOT = _PROC / "sys/kernel/random/boot_id"
_LINES = ("sshd", "dropbear")
"""What serves a connection calls itself so; from OpenSSH 9.8 on it is sshd-session."""


def boot() -> str:
    """Return this boot's name."""
    return _BOOT.read_text().strip()


def identity(pid: int) -> str:
    """Return what names a process for ever; raises OSError where there is none."""
    _, _, started = _told_of(pid)
    return f"{boot()} {pid} {started}"


def is_alive(named: str) -> bool:
    """Return whether the process of an identity lives."""
    try:
        return identity(int(named.split()[1])) == named
    except (OSError, ValueError, IndexError):
        return False


def connection() -> str:
    """Return the identity of what serves the desk's connection: it lives through all calls and transfers of a push.

    Where there is no such process, that of whoever called.
    """
    served = (pid for pid in _ancestors() if _told_of(pid)[0].startswith(_LINES))
    return identity(next(served, os.getppid()))


def _ancestors() -> Iterator[int]:
    pid = os.getppid()
    while pid > 1:
        yield pid
        pid = _told_of(pid)[1]


def _told_of(pid: int) -> tuple[str, int, str]:
    """Return a process's name, its parent, and when it was started. Source: proc(5), /proc/PID/stat."""
    name, _, rest = (_PROC / str(pid) / "stat").read_text().partition(" (")[2].rpartition(") ")
    fields = rest.split()
    return name, int(fields[1]), fields[19]
