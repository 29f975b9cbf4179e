"""Start a worker process, call functions in it, and end it. The process runs `worker_loop`."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from subprocess import DEVNULL, Popen, TimeoutExpired
from threading import Lock
from typing import Any

from robotcore.errors import BackendError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.sweep import supervisor
from robotcore.sweep.worker_loop import read_reply

_STDERR = 2
_START_S = 120.0
"""The most seconds that a process takes to start."""

_EXIT_GRACE_S = 1.0
"""A worker has this many seconds to exit after it closed its pipe. Then its parent kills it."""

_SUPERVISOR_S = 10.0
"""A supervisor has this many seconds to end its worker and the worker's children. Then the parent kills it."""

_MAX_WAIT_S = 2e6
"""The longest wait in seconds, 23 days. The operating system accepts only a little more."""

_CHUNK_BYTES = 2**16

MAX_REPLY_BYTES = 64 * 2**20
"""The most bytes of a reply. The reply of a day-long run, with its path and its picture, is far smaller."""

_GARBLED_REMEDY = "Check whether the app writes to a file descriptor that it did not open"


class NoWorkerError(BackendError):
    """No worker process can be started.

    `robotcore.errors` does not define this class, so a reply of a worker cannot contain it.
    """


class WorkerDiedError(Exception):
    """The worker process ended during a call, or its parent killed it because of an unreadable reply."""


class WorkerHungError(Exception):
    """A call exceeded its time limit, so the parent killed the worker process."""


class WorkerProcess:
    """Calls functions in another process, one at a time.

    The process starts at the first call. If it ends during a call, the next call starts a new one. It has its own
    session, so Ctrl-C in a terminal does not reach it. Its standard input is empty, and its standard output goes to
    standard error. It ends with its parent.

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

    def __repr__(self) -> str:
        state = "killed" if self._is_killed else "started" if self._process else "not started"
        return f"<WorkerProcess {state}>"

    def call(self, function: Callable[..., object], *args: object, limit_s: float) -> Any:
        """Call a function in the process, and return its result, converted to JSON and back.

        function: a function that `pickle` can find by its module and name.
        limit_s: the most seconds of wall time that the call takes.

        If the function raises a RobotcoreError, this method raises the same error. Any other exception of the function
        becomes a RobotcoreError. Raises WorkerDiedError and WorkerHungError. Raises NoWorkerError if no process can be
        started.
        """
        process = self._get_ready_process()
        try:
            process.connection.send((function, args))
            result, raised = read_reply(process.read_line(limit_s))
        except TimeoutError as error:
            self.close()
            raise WorkerHungError(f"it did not end within {limit_s:g} s of wall time") from error
        except (EOFError, OSError) as error:
            raise WorkerDiedError(_format_status(self._end(_EXIT_GRACE_S))) from error
        except ValueError as error:
            self.close()
            raise WorkerDiedError(f"its reply cannot be read. {_GARBLED_REMEDY}") from error
        if raised:
            raise raised
        return result

    def kill(self) -> None:
        """End the process and start no new one. A call in another thread then raises WorkerDiedError."""
        with self._lock:
            self._is_killed = True
            if self._process:
                self._process.kill()

    def close(self) -> None:
        """End the process. No call may be running."""
        self._end()

    def _end(self, grace_s: float = 0.0) -> int:
        """End the process if there is one, and return its exit status as `Popen` does, else 0."""
        with self._lock:
            process, self._process = self._process, None
        return process.end(grace_s) if process else 0

    def _get_ready_process(self) -> _Process:
        """Return a process that waits for a call."""
        if self._process and not self._process.connection.poll():
            return self._process
        self._end()  # the process ended, or the app wrote to its pipe while no call was running
        process = self._start_process()
        try:
            process.read_line(_START_S)
        except TimeoutError as error:
            self._end()
            raise NoWorkerError(
                f"a worker process did not start within {_START_S:g} s. "
                "Check that this command ends: python -c 'import cv2'",
                kind="worker-start-timeout",
                limit_s=_START_S,
            ) from error
        except (EOFError, OSError) as error:
            how = _format_status(self._end(_EXIT_GRACE_S))
            raise NoWorkerError(
                f"a worker process ended while it started: {how}. Its output above says why",
                kind="worker-start-died",
                how=how,
            ) from error
        return process

    def _start_process(self) -> _Process:
        with self._lock:
            if self._is_killed:
                raise WorkerDiedError(_format_status(-signal.SIGKILL))
            try:
                self._process = process = _Process()
            except OSError as error:
                raise NoWorkerError(
                    f"no worker process can be started: {error.strerror}. Take fewer --jobs", kind="worker-not-started"
                ) from error
        return process


class _Process:
    """A running process, and the parent's end of the pipe to it."""

    def __init__(self) -> None:
        self.connection, theirs = Pipe()
        with theirs:
            handle = theirs.fileno()
            path = f"import sys; sys.path[:] = {sys.path!r}"
            code = f"{path}; from robotcore.sweep.worker_loop import run_worker_loop; run_worker_loop({handle})"
            self._popen = Popen(  # noqa: S603  the Python that runs this
                [sys.executable, "-c", code],
                stdin=DEVNULL,
                stdout=_STDERR,
                pass_fds=[handle],
                start_new_session=True,
            )

    def read_line(self, limit_s: float) -> bytes:
        """Read one line from the process within ``limit_s`` seconds.

        Raises TimeoutError, EOFError if the process closed the pipe, and ValueError if the line is too long.
        """
        clock, line, chunk = MonotonicClock(), bytearray(), b""
        while b"\n" not in chunk:
            if not self.connection.poll(min(max(limit_s - clock.now(), 0.0), _MAX_WAIT_S)):
                raise TimeoutError
            chunk = os.read(self.connection.fileno(), _CHUNK_BYTES)
            if not chunk:
                raise EOFError
            line += chunk
            if len(line) > MAX_REPLY_BYTES:
                raise ValueError(f"a line of more than {MAX_REPLY_BYTES} bytes")
        return bytes(line)

    def kill(self) -> None:
        """End the process and every process that it started. Outside of Linux, end its process group."""
        with suppress(ProcessLookupError, PermissionError):  # macOS raises PermissionError for an ended process
            if supervisor.IS_AVAILABLE:
                os.kill(self._popen.pid, signal.SIGTERM)
            else:
                os.killpg(self._popen.pid, signal.SIGKILL)

    def end(self, grace_s: float) -> int:
        """End the process and every process that it started, and return its exit status.

        grace_s: the most seconds to wait for the process to exit by itself.
        """
        with suppress(TimeoutExpired):
            self._popen.wait(grace_s)
        if self._popen.returncode is None or not supervisor.IS_AVAILABLE:
            self.kill()  # the process may have ended, but other processes of its group may still run
        self.connection.close()
        with suppress(TimeoutExpired):
            return self._popen.wait(_SUPERVISOR_S)
        os.killpg(self._popen.pid, signal.SIGKILL)
        return self._popen.wait()


def _format_status(status: int) -> str:
    """Return the text for a status of `Popen`."""
    if status >= 0:
        return f"exit status {status}"
    with suppress(ValueError):  # a real-time signal has no name
        return signal.Signals(-status).name
    return f"signal {-status}"
