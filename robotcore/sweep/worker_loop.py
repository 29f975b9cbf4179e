"""The main loop of a worker process, and its replies as lines of JSON."""

from __future__ import annotations

import json
import os
import pickle
import sys
from contextlib import suppress
from multiprocessing.connection import Connection
from queue import SimpleQueue
from threading import Thread
from typing import Any, NoReturn

from robotcore import errors
from robotcore.errors import RobotcoreError
from robotcore.sweep import supervisor

_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")

_ERROR_KEY = "robotcore.errors"
"""The key that marks a JSON object as an error."""

_REPLACEABLE = {"_traceback_text", "kind", "fields"}
"""A reply may set only these class attributes of an error. It may not set others, such as an exit status."""


def run_worker_loop(handle: int) -> NoReturn:
    """Receive a call, run it, send the result, and repeat. Exit if the parent closes the pipe.

    handle: the file descriptor of this end of the pipe.
    """
    supervisor.supervise(handle)
    sys.stdout = sys.stderr  # stderr is line-buffered, so a crash loses no line
    _prepare()
    connection, calls = Connection(handle), SimpleQueue[bytes]()
    _close_in_subprocesses(connection)
    Thread(target=_receive_calls, args=(connection, calls), daemon=True).start()
    with suppress(OSError):  # the parent has ended, or this process was forked by the app
        _send(connection, write_reply("ready"))
        while True:
            _send(connection, _run_call(calls.get()))
    os._exit(1)


def _send(connection: Connection, line: bytes) -> None:
    while line:
        line = line[os.write(connection.fileno(), line) :]


def _close_in_subprocesses(connection: Connection) -> None:
    """Close the pipe in every process that the app starts.

    A process that inherits the pipe could send a reply, or keep the pipe open after this process ended.
    """
    os.set_inheritable(connection.fileno(), False)
    os.register_at_fork(after_in_child=connection.close)


def _receive_calls(connection: Connection, calls: SimpleQueue[bytes]) -> None:
    """Queue calls. If the parent closes the pipe, exit at once, even during a call."""
    try:
        while True:
            calls.put(connection.recv_bytes())
    except (EOFError, OSError):
        os._exit(1)


def _run_call(call: bytes) -> bytes:
    """Run a call, and return its result or its error as a line."""
    try:
        function, arguments = pickle.loads(call)  # noqa: S301  from the parent of this process
        return write_reply(function(*arguments))
    except RobotcoreError as error:
        return _write_error(error)
    except Exception as error:  # noqa: BLE001  the function or the JSON encoder raised it
        return write_reply(error=RobotcoreError(f"{type(error).__name__}: {error}"))


def _write_error(error: RobotcoreError) -> bytes:
    try:
        return write_reply(error=error)
    except (TypeError, ValueError):  # an attribute that JSON cannot hold
        return write_reply(error=RobotcoreError(str(error)))


def _prepare() -> None:
    """Limit libraries to one thread, and import what runs need."""
    os.environ.update(dict.fromkeys(_THREAD_VARIABLES, "1"))
    import cv2

    import robotcore.runtime.session
    import robotcore.view.picture  # noqa: F401

    cv2.setNumThreads(1)


def write_reply(result: Any = None, error: RobotcoreError | None = None) -> bytes:
    """Return the line for a result or an error. Raises TypeError or ValueError if JSON cannot hold it.

    >>> read_reply(write_reply([1, "a"]))
    ([1, 'a'], None)
    """
    return json.dumps({"result": result, "error": error}, default=_encode_error).encode() + b"\n"


def read_reply(line: bytes) -> tuple[Any, RobotcoreError | None]:
    """Return the result in a reply, and the error or None. Raises ValueError if the line is no reply."""
    try:
        reply = json.loads(line, object_hook=_decode_error)
        result, error = reply["result"], reply["error"]
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError) as problem:
        raise ValueError(f"{type(problem).__name__}: {problem}") from problem
    return result, error if isinstance(error, RobotcoreError) else None


def _encode_error(value: object) -> dict[str, Any]:
    """Return an error as a JSON object: its class in `robotcore.errors`, its arguments and its attributes."""
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
