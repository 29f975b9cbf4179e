"""A worker process: call functions in it from the parent, run its main loop, and send replies as JSON."""

from __future__ import annotations

import json
import os
import pickle
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from queue import SimpleQueue
from subprocess import DEVNULL, Popen, TimeoutExpired
from threading import Lock, Thread
from typing import Any, NoReturn

from robotcore import errors
from robotcore.errors import BackendError, RobotcoreError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.sweep import supervisor

_STDERR = 2
_START_S = 120.0
"""A process that is not ready within this time hangs."""

_EXIT_GRACE_S = 1.0
"""A process that has closed its end of the pipe is killed if it does not exit within this time."""

_SUPERVISOR_S = 10.0
"""A supervisor that needs longer to end its worker and the worker's children is ended."""

_MAX_WAIT_S = 2e6
"""The longest wait that the system accepts, rounded down: 23 days."""

_CHUNK_BYTES = 2**16
_GARBLED_REMEDY = "Check whether the app writes to a file descriptor that it did not open"

_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")

MAX_REPLY_BYTES = 64 * 2**20
"""The most bytes of a reply. The path of a run of a day and its picture are far below it."""

_ERROR_KEY = "robotcore.errors"
"""The key that tells an error from a mapping."""

_REPLACEABLE = {"_traceback_text", "kind", "fields"}
"""The attributes of an error that its class gives a default. No other one replaces what the class defines, such as an
exit status."""


class NoWorkerError(BackendError):
    """No process can be started. No process can send this class: it is none of `robotcore.errors`."""


class WorkerDiedError(Exception):
    """The process ended during a call, or was killed because its reply cannot be read."""


class WorkerHungError(Exception):
    """The call took too long; its process was killed."""


class WorkerProcess:
    """Calls functions in another process, one at a time; after one that was its end, the next has a new process.

    The process is a session of its own, so that Ctrl-C in the terminal is its parent's business. It has nothing to
    read, and what it prints goes to standard error. It does not outlive its parent.
    """

    def __init__(self) -> None:
        self._process: _Process | None = None
        self._is_killed = False
        self._lock = Lock()

    def __repr__(self) -> str:
        state = "killed" if self._is_killed else "started" if self._process else "not started"
        return f"<WorkerProcess {state}>"

    def call(self, function: Callable[..., object], *args: object, limit_s: float) -> Any:
        """Return what the function returns over there within ``limit_s`` seconds of wall time, as JSON has it.

        Raises the RobotcoreError that it raises (any other exception comes as one), ChildDiedError, ChildHungError, and
        NoChildError if no process can be started.
        """
        process = self._get_ready_process()
        try:
            process.connection.send((function, args))
            result, raised = read_reply(process.read_line(limit_s))
        except TimeoutError as error:
            self.close()
            raise WorkerHungError(f"no end after {limit_s:g} s of wall time") from error
        except (EOFError, OSError) as error:
            raise WorkerDiedError(_format_status(self._end(_EXIT_GRACE_S))) from error
        except ValueError as error:
            self.close()
            raise WorkerDiedError(f"its answer cannot be read. {_GARBLED_REMEDY}") from error
        if raised:
            raise raised
        return result

    def kill(self) -> None:
        """End the process, and let there be no other; a call that is under way, in another thread, raises."""
        with self._lock:
            self._is_killed = True
            if self._process:
                self._process.kill()

    def close(self) -> None:
        """End the process, if there is one, while no call is under way."""
        self._end()

    def _end(self, grace_s: float = 0.0) -> int:
        """End the process; return its status, as `Popen` tells it."""
        with self._lock:
            process, self._process = self._process, None
        return process.end(grace_s) if process else 0

    def _get_ready_process(self) -> _Process:
        """Return the process, which waits for what to do."""
        if self._process and not self._process.connection.poll():
            return self._process
        self._end()  # it wrote without a call, or it ended: a thread of the app lived on
        process = self._start_process()
        try:
            process.read_line(_START_S)
        except TimeoutError as error:
            self._end()
            raise NoWorkerError(
                f"the worker processes do not start within {_START_S:g} s. Does python -c 'import cv2' end?",
                kind="worker-start-timeout",
                limit_s=_START_S,
            ) from error
        except (EOFError, OSError) as error:
            how = _format_status(self._end(_EXIT_GRACE_S))
            raise NoWorkerError(
                f"the worker processes die before they run anything: {how}", kind="worker-start-died", how=how
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
    """A worker's process, and this end of the pipe to it."""

    def __init__(self) -> None:
        self.connection, theirs = Pipe()
        with theirs:
            handle = theirs.fileno()
            path = f"import sys; sys.path[:] = {sys.path!r}"
            code = f"{path}; from robotcore.sweep.worker import worker_main; worker_main({handle})"
            self._popen = Popen(  # noqa: S603  this very Python
                [sys.executable, "-c", code],
                stdin=DEVNULL,
                stdout=_STDERR,
                pass_fds=[handle],
                start_new_session=True,
            )

    def read_line(self, limit_s: float) -> bytes:
        """Return what the process writes up to the end of a line.

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
        """End the process and the processes that it started; outside of Linux those of its process group alone."""
        with suppress(ProcessLookupError, PermissionError):  # macOS permits no signal to one that is gone
            if supervisor.IS_AVAILABLE:
                os.kill(self._popen.pid, signal.SIGTERM)
            else:
                os.killpg(self._popen.pid, signal.SIGKILL)

    def end(self, grace_s: float) -> int:
        """End the process if it does not end in this time, and all that it has started; return its status."""
        with suppress(TimeoutExpired):
            self._popen.wait(grace_s)
        if self._popen.returncode is None or not supervisor.IS_AVAILABLE:
            self.kill()  # also where it is gone: its group lives on, and keeps its number, while one of the group does
        self.connection.close()
        with suppress(TimeoutExpired):
            return self._popen.wait(_SUPERVISOR_S)
        os.killpg(self._popen.pid, signal.SIGKILL)
        return self._popen.wait()


def _format_status(status: int) -> str:
    """Return a status of `Popen` in words."""
    if status >= 0:
        return f"exit status {status}"
    with suppress(ValueError):  # a real-time signal has a number alone
        return signal.Signals(-status).name
    return f"signal {-status}"


def worker_main(handle: int) -> NoReturn:
    """Main loop of a worker process: receive a call, run it, send the result; exit if the pipe is closed."""
    supervisor.supervise(handle)
    sys.stdout = sys.stderr  # line by line: what waits in a buffer is lost with the process
    prepare()
    connection, calls = Connection(handle), SimpleQueue[bytes]()
    _close_in_subprocesses(connection)
    Thread(target=_receive_calls, args=(connection, calls), daemon=True).start()
    with suppress(OSError):  # nobody is there any more, or this is a copy that an app has made of the process
        _send(connection, write_reply("ready"))
        while True:
            _send(connection, _run_call(calls.get()))
    os._exit(1)


def _send(connection: Connection, line: bytes) -> None:
    while line:
        line = line[os.write(connection.fileno(), line) :]


def _close_in_subprocesses(connection: Connection) -> None:
    """Close the pipe in every process that an app starts: it would hide the end of this process, or reply for it."""
    os.set_inheritable(connection.fileno(), False)
    os.register_at_fork(after_in_child=connection.close)


def _receive_calls(connection: Connection, calls: SimpleQueue[bytes]) -> None:
    """Queue calls; exit at once if the parent closes the pipe, also during a call."""
    try:
        while True:
            calls.put(connection.recv_bytes())
    except (EOFError, OSError):
        os._exit(1)


def _run_call(call: bytes) -> bytes:
    """Run a call, and return its result or error as a line."""
    try:
        function, arguments = pickle.loads(call)  # noqa: S301  from the parent of this process
        return write_reply(function(*arguments))
    except RobotcoreError as error:
        return _write_error(error)
    except Exception as error:  # noqa: BLE001  whatever it is, and what JSON cannot hold
        return write_reply(error=RobotcoreError(f"{type(error).__name__}: {error}"))


def _write_error(error: RobotcoreError) -> bytes:
    try:
        return write_reply(error=error)
    except (TypeError, ValueError):  # an attribute that JSON cannot hold
        return write_reply(error=RobotcoreError(str(error)))


def prepare() -> None:
    """Make a process ready for runs: one thread each, everything imported."""
    os.environ.update(dict.fromkeys(_THREAD_VARIABLES, "1"))
    import cv2

    import robotcore.runtime.session
    import robotcore.view.picture  # noqa: F401

    cv2.setNumThreads(1)


def write_reply(result: Any = None, error: RobotcoreError | None = None) -> bytes:
    """Return a line for what a call returned or raised; TypeError or ValueError if JSON cannot hold it."""
    return json.dumps({"result": result, "error": error}, default=_encode_error).encode() + b"\n"


def read_reply(line: bytes) -> tuple[Any, RobotcoreError | None]:
    """Return what the call returned, and the error that it raised, if it did; ValueError if the line is no reply."""
    try:
        reply = json.loads(line, object_hook=_decode_error)
        result, error = reply["result"], reply["error"]
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError) as problem:
        raise ValueError(f"{type(problem).__name__}: {problem}") from problem
    return result, error if isinstance(error, RobotcoreError) else None


def _encode_error(value: object) -> dict[str, Any]:
    """Return an error as JSON has it: its kind among ours, its arguments and its attributes."""
    if not isinstance(value, RobotcoreError):
        raise TypeError(f"cannot send a {type(value).__name__} through a pipe")
    _, (kind, arguments, state) = value.__reduce__()
    return {_ERROR_KEY: [kind.__name__, arguments, state]}


def _decode_error(read: dict[str, Any]) -> Any:
    if _ERROR_KEY not in read:
        return read
    name, arguments, state = read[_ERROR_KEY]
    kind = getattr(errors, name)
    if not (isinstance(kind, type) and issubclass(kind, RobotcoreError)):
        raise TypeError(f"{name} is no error of robotcore")
    error = kind.__new__(kind)
    error.args = tuple(arguments)
    error.__dict__.update((key, value) for key, value in state.items() if key in _REPLACEABLE or not hasattr(kind, key))
    return error
