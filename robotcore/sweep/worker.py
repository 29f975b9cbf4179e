"""Start a worker process, call functions in it, and end it. The process runs `worker_loop`."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from selectors import EVENT_READ, DefaultSelector
from subprocess import DEVNULL, TimeoutExpired
from threading import Lock
from typing import Any

from robotcore.child_process import start_linked_process
from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.sweep.worker_loop import CALL_SIZE, read_reply
from robotcore.system import HAS_POSIX, IS_LINUX

_STDERR = 2
_START_S = 120.0
"""The time limit for the start of a worker process, in seconds."""

_EXIT_GRACE_S = 1.0
"""The seconds that a worker has to exit after it closed its link. After them, the parent kills it."""

_SUPERVISOR_GRACE_S = 10.0
"""The seconds that a supervisor has to end its worker and the worker's children. After them, the parent kills it."""

_MAX_WAIT_S = 2e6
"""The longest time limit of `select`, in seconds: 23 days. The operating system accepts little more."""

_CHUNK_BYTES = 2**16

MAX_REPLY_BYTES = 64 * 2**20
"""The maximum length of a reply, in bytes. The reply of a day-long run, with its path and picture, is far shorter."""


class NoWorkerError(BackendError):
    """No worker process can be started.

    This class is not in `robotcore.errors`, so that no reply of a worker process can raise it.
    """


class WorkerEndedError(Exception):
    """The worker process ended during a call, or its parent killed it. The text is a clause without its subject."""


class WorkerProcess:
    """Calls functions in a worker process, one at a time.

    The first call starts the process. If the process ends during a call, the next call starts a new process. The
    process has its own session, so Ctrl-C in a terminal does not end it. Its standard input is empty, and its standard
    output goes to standard error. It ends when its parent ends.

    >>> import math
    >>> from contextlib import closing
    >>> with closing(WorkerProcess()) as worker:
    ...     worker.call(math.hypot, 3, 4, limit_s=60.0)
    5.0
    """

    def __init__(self) -> None:
        self._process: _Process | None = None
        self._is_killed = False
        self._lock = Lock()

    def call(self, function: Callable[..., object], *args: object, limit_s: float) -> Any:
        """Call a function in the process, and return its result, converted to JSON and back.

        function: a function that `pickle` can find by its module and name.
        limit_s: the time limit of the call, in seconds of wall time.

        Raises the RobotcoreError that the function raised. Any other exception of the function becomes a
        RobotcoreError. Raises WorkerEndedError if the process ends during the call, exceeds the time limit or sends an
        unreadable reply, and NoWorkerError if no process can be started.
        """
        process = self._get_ready_process()
        try:
            process.send(pickle.dumps((function, args)))
            result, raised = read_reply(process.read_line(limit_s))
        except TimeoutError as error:
            self.close()
            raise WorkerEndedError(f"hung: not done after {limit_s:g} s of wall time") from error
        except (EOFError, OSError) as error:
            raise WorkerEndedError(_format_status(self._end(_EXIT_GRACE_S))) from error
        except ValueError as error:
            self.close()
            raise WorkerEndedError(
                "sent an unreadable reply. Check to which file descriptors the app writes"
            ) from error
        if raised:
            raise raised
        return result

    def kill(self) -> None:
        """End the process, and start no other. A running call, in another thread, raises WorkerEndedError."""
        with self._lock:
            self._is_killed = True
            if self._process:
                self._process.kill()

    def close(self) -> None:
        """End the process. Must not be called during a call."""
        self._end()

    def _end(self, grace_s: float = 0.0) -> int:
        """End the process, and return its exit status as `Popen` does: -n for signal n. Without a process, return 0."""
        with self._lock:
            process, self._process = self._process, None
        return process.end(grace_s) if process else 0

    def _get_ready_process(self) -> _Process:
        if self._process and not self._process.has_data_within(0.0):
            return self._process
        self._end()  # the process ended, or the app wrote to its link while no call was running
        try:
            with self._lock:
                if self._is_killed:
                    raise WorkerEndedError("was ended by its parent")
                self._process = process = _Process()
            process.read_line(_START_S)
        except TimeoutError:
            self._end()
            problem = f"it was not ready after {_START_S:g} s. Importing OpenCV may hang: try python -c 'import cv2'"
        except (EOFError, ConnectionError):
            problem = f"it {_format_status(self._end(_EXIT_GRACE_S))}. See its output above"
        except OSError as error:
            problem = f"{error.strerror}. Use fewer --jobs"
        else:
            return process
        raise NoWorkerError(f"no worker process can be started: {problem}", kind="worker-not-started")


class _Process:
    def __init__(self) -> None:
        path = f"import sys; sys.path[:] = {sys.path!r}"
        code = f"{path}; from robotcore.sweep.worker_loop import run_worker_loop; run_worker_loop()"
        self._popen, self._link = start_linked_process(code, stdout=_STDERR if sys.stderr else DEVNULL)

    def send(self, call: bytes) -> None:
        """Send a pickled call. Raises OSError if the process has ended."""
        self._link.sendall(CALL_SIZE.pack(len(call)) + call)

    def has_data_within(self, limit_s: float) -> bool:
        """Wait at most ``limit_s`` seconds. Return whether the process has sent data, or has closed the link."""
        with DefaultSelector() as selector:  # select() itself fails with more than 1024 open files
            selector.register(self._link, EVENT_READ)
            return bool(selector.select(min(limit_s, _MAX_WAIT_S)))

    def read_line(self, limit_s: float) -> bytes:
        """Return a line from the process.

        Raises TimeoutError after ``limit_s`` seconds, EOFError if the process closed the link, and ValueError if the
        line has more than `MAX_REPLY_BYTES`.
        """
        clock, line, chunk = MonotonicClock(), bytearray(), b""
        while b"\n" not in chunk:
            if not self.has_data_within(max(limit_s - clock.now(), 0.0)):
                raise TimeoutError
            chunk = self._link.recv(_CHUNK_BYTES)
            if not chunk:
                raise EOFError
            line += chunk
            if len(line) > MAX_REPLY_BYTES:
                raise ValueError(f"a line has more than {MAX_REPLY_BYTES} bytes")
        return bytes(line)

    def kill(self) -> None:
        """End the worker process and all its descendants: on macOS its process group only, on Windows itself only."""
        with suppress(ProcessLookupError, PermissionError):  # macOS raises PermissionError for an ended process
            if IS_LINUX:
                os.kill(self._popen.pid, signal.SIGTERM)  # the supervisor ends the others
            else:
                self._kill_group()

    def end(self, grace_s: float) -> int:
        """End the worker process and its descendants, as `kill` does, and return its exit status.

        grace_s: the seconds that the process has to exit by itself before it is killed.
        """
        with suppress(TimeoutExpired):
            self._popen.wait(grace_s)
        if self._popen.returncode is None or not IS_LINUX:
            self.kill()  # the process may have ended, but other processes of its group may still run
        self._link.close()
        with suppress(TimeoutExpired):
            return self._popen.wait(_SUPERVISOR_GRACE_S)
        self._kill_group()
        return self._popen.wait()

    def _kill_group(self) -> None:
        if HAS_POSIX:
            os.killpg(self._popen.pid, signal.SIGKILL)
        else:
            self._popen.kill()


def _format_status(status: int) -> str:
    if status >= 0:
        return f"ended with exit status {status}"
    with suppress(ValueError):  # a real-time signal has no name
        return f"was ended by {signal.Signals(-status).name}"
    return f"was ended by signal {-status}"
