"""The lock of the robot's folders. Only the process that holds the lock may change releases and environments.

The kernel releases the lock when the process ends.
"""

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
"""The default time limit for the wait for the lock, in s."""

POLL_S = 0.1


@contextmanager
def hold_lock(layout: Layout, doing: str, timeout_s: float = TIMEOUT_S) -> Iterator[int]:
    """Hold the robot's lock during a ``with`` block, and yield the file handle of the lock.

    If a child process inherits the handle, the lock stays held until that child has ended too.

    doing: the work of this process in words, for the error message of another process that waits in vain.
    timeout_s: the time limit for the wait, in s.
    Raises AgentError of the kind ``busy`` after the time limit.
    """
    handle = _acquire(layout, timeout_s)
    try:
        _write_holder(handle, f"{doing}, process {os.getpid()}")
        yield handle
    finally:
        os.close(handle)


def _acquire(layout: Layout, timeout_s: float) -> int:
    while True:
        layout.root.mkdir(parents=True, exist_ok=True)
        handle = os.open(layout.lock, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            _wait_for(handle, timeout_s)
            if _is_at(layout.lock, handle):
                return handle
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)  # another process has removed the lock file meanwhile


def _wait_for(handle: int, timeout_s: float) -> None:
    for _ in range(round(timeout_s / POLL_S)):
        if _try_lock(handle):
            return
        Event().wait(POLL_S)
    if not _try_lock(handle):
        holder = os.pread(handle, 200, 0).decode(errors="replace") or "an unknown process"
        problem = f"another deploy is at work on this robot: {holder}"
        raise AgentError(problem, "Wait for it to end, and try again", "busy", holder=holder)


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


def _write_holder(handle: int, text: str) -> None:
    """Write the holder's text into the lock file. A full disk raises nothing, because `remove` must work on it too."""
    with suppress(OSError):
        os.ftruncate(handle, 0)
        os.pwrite(handle, text.encode(), 0)
