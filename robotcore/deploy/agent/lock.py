"""The robot's lock: one process at a time changes what is installed. The kernel releases it when the process ends."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Event

from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.rpc import AgentError

TIMEOUT_S = 20.0
"""For another's work that is about to end."""

POLL_S = 0.1


@contextmanager
def hold_lock(layout: Layout, doing: str, patience_s: float = TIMEOUT_S) -> Iterator[int]:
    """Hold the robot's lock, and yield its file handle: a child that is given it holds the lock for its own life too.

    ``doing`` is told to whoever waits in vain. Raises RefusalError of the kind ``busy``.
    """
    handle = _acquire(layout, patience_s)
    try:
        _write_holder(handle, f"{doing}, process {os.getpid()}")
        yield handle
    finally:
        os.close(handle)


def _acquire(layout: Layout, patience_s: float) -> int:
    """Return the handle of the lock, once it is ours."""
    while True:
        layout.root.mkdir(parents=True, exist_ok=True)
        handle = os.open(layout.lock, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            _wait_for(handle, patience_s)
            if _is_at(layout.lock, handle):
                return handle
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)  # of a robot from which all was taken away meanwhile


def _wait_for(handle: int, patience_s: float) -> None:
    for _ in range(round(patience_s / POLL_S)):
        if _try_lock(handle):
            return
        Event().wait(POLL_S)
    if not _try_lock(handle):
        who = os.pread(handle, 200, 0).decode(errors="replace") or "nobody knows which"
        fault = f"another deploy is at work on this robot: {who}"
        raise AgentError(fault, "Wait for it to end, and try again", "busy", holder=who)


def _try_lock(handle: int) -> bool:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _is_at(path: Path, handle: int) -> bool:
    try:
        return os.path.samestat(path.stat(), os.fstat(handle))
    except FileNotFoundError:
        return False


def _write_holder(handle: int, words: str) -> None:
    """Say who holds it, unless the disk is full: then a robot must be stopped and cleared all the same."""
    with suppress(OSError):
        os.ftruncate(handle, 0)
        os.pwrite(handle, words.encode(), 0)
