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
"""The time limit for the start of a worker process, in seconds."""

_EXIT_GRACE_S = 1.0
"""The seconds that a worker has to exit after it closed its pipe. After them, the parent kills it."""

_SUPERVISOR_GRACE_S = 10.0
"""The seconds that a supervisor has to end its worker and the worker's children. After them, the parent kills it."""

_MAX_WAIT_S = 2e6
"""The longest time limit of `Connection.poll`, in seconds: 23 days. The operating system accepts little more."""

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
            process.connection.send((function, args))
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
        if self._process and not self._process.connection.poll():
            return self._process
        self._end()  # the process ended, or the app wrote to its pipe while no call was running
        try:
            with self._lock:
                if self._is_killed:
                    raise WorkerEndedError(_format_status(-signal.SIGKILL))
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
        """Return a line from the process.

        Raises TimeoutError after ``limit_s`` seconds, EOFError if the process closed the pipe, and ValueError if the
        line has more than `MAX_REPLY_BYTES`.
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
                raise ValueError(f"a line has more than {MAX_REPLY_BYTES} bytes")
        return bytes(line)

    def kill(self) -> None:
        """End the worker process and all its descendants. Outside of Linux, end its process group only."""
        with suppress(ProcessLookupError, PermissionError):  # macOS raises PermissionError for an ended process
            if supervisor.IS_AVAILABLE:
                os.kill(self._popen.pid, signal.SIGTERM)
            else:
                os.killpg(self._popen.pid, signal.SIGKILL)

    def end(self, grace_s: float) -> int:
        """End the worker process and all its descendants, and return its exit status.

        grace_s: the seconds that the process has to exit by itself before it is killed.
        """
        with suppress(TimeoutExpired):
            self._popen.wait(grace_s)
        if self._popen.returncode is None or not supervisor.IS_AVAILABLE:
            self.kill()  # the process may have ended, but other processes of its group may still run
        self.connection.close()
        with suppress(TimeoutExpired):
            return self._popen.wait(_SUPERVISOR_GRACE_S)
        os.killpg(self._popen.pid, signal.SIGKILL)
        return self._popen.wait()


def _format_status(status: int) -> str:
    if status >= 0:
        return f"ended with exit status {status}"
    with suppress(ValueError):  # a real-time signal has no name
        return f"was ended by {signal.Signals(-status).name}"
    return f"was ended by signal {-status}"
