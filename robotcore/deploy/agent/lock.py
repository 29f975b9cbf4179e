"""The lock of the robot's folders. Only the process that holds the lock may change releases and environments.

The kernel releases the lock when the process ends.
"""

from __future__ import annotations

import fcntl
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout

TIMEOUT_S, POLL_S = 20.0, 0.1
"""The default time limit for the wait for the lock, and the time between two attempts, in s."""


@contextmanager
def hold_lock(layout: Layout, doing: str, timeout_s: float = TIMEOUT_S) -> Iterator[int]:
    """Hold the robot's lock during a ``with`` block, and yield the file handle of the lock.

    If a child process inherits the handle, the lock stays held until that child has ended too.

    doing: the work of this process in words, for the error message of another process that waits in vain.
    timeout_s: the time limit for the wait, in s.
    Raises AgentError of the kind ``busy`` after the time limit.
    """
    until = time.monotonic() + timeout_s
    while (handle := _try_lock(layout, is_last=time.monotonic() >= until)) is None:
        time.sleep(POLL_S)
    try:
        with suppress(OSError):  # `remove` must work on a full disk too
            os.ftruncate(handle, 0)
            os.pwrite(handle, f"{doing}, process {os.getpid()}".encode(), 0)
        yield handle
    finally:
        os.close(handle)


def _try_lock(layout: Layout, *, is_last: bool) -> int | None:
    """Return the handle of the locked file; None if another process holds the lock, or has removed the file."""
    layout.root.mkdir(parents=True, exist_ok=True)
    handle = os.open(layout.lock, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.path.samestat(layout.lock.stat(), os.fstat(handle)):
            return handle
    except FileNotFoundError:
        pass
    except BlockingIOError:
        if is_last:
            holder = os.pread(handle, 200, 0).decode(errors="replace") or "an unknown process"
            os.close(handle)
            problem = f"another deploy is at work on this robot: {holder}"
            raise AgentError(problem, "Wait for it to end, and try again", "busy", holder=holder) from None
    os.close(handle)
    return None
