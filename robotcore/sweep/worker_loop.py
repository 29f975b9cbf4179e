"""The main loop of a worker process, and its replies as lines of JSON."""

from __future__ import annotations

import json
import os
import pickle
import struct
import sys
from contextlib import suppress
from queue import SimpleQueue
from socket import socket
from threading import Thread
from typing import Any, NoReturn

from robotcore import errors
from robotcore.child_process import receive_link
from robotcore.errors import RobotcoreError
from robotcore.system import HAS_POSIX, IS_LINUX

_THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")

_ERROR_KEY = "robotcore.errors"
"""The key of a JSON object that contains an error."""

_ERROR_ATTRIBUTES = {"_traceback_text", "kind", "fields"}
"""The class attributes of an error that a reply may replace. A reply cannot replace others, such as the exit status."""


_CHUNK_BYTES = 2**16

CALL_SIZE = struct.Struct("!Q")
"""The number of bytes of a pickled call, which precedes the call."""


def run_worker_loop() -> NoReturn:
    """Execute the calls that the parent sends, and send their results. Exits if the parent closes the link.

    The first argument of the process is the address of the link.
    """
    link = receive_link(sys.argv.pop(1))
    if IS_LINUX:
        from robotcore.sweep.supervisor import supervise

        supervise(link)
    sys.stdout = sys.stderr  # stderr is line-buffered, so a crash loses no line
    _import_libraries()
    calls = SimpleQueue[bytes]()
    if HAS_POSIX:  # a process that the app forks could send a reply, or keep the link open after the end of the worker
        os.register_at_fork(after_in_child=link.close)
    Thread(target=_receive_calls, args=(link, calls), daemon=True).start()
    with suppress(OSError):  # the parent has ended, or this process was forked by the app
        link.sendall(write_reply("ready"))
        while True:
            link.sendall(_run_call(calls.get()))
    os._exit(1)


def _import_libraries() -> None:
    """Limit the libraries to one thread each, and import them, so that the time limit of a run excludes the imports."""
    os.environ.update(dict.fromkeys(_THREAD_VARIABLES, "1"))
    import cv2

    import robotcore.runtime.session
    import robotcore.view.picture  # noqa: F401

    cv2.setNumThreads(1)


def _receive_calls(link: socket, calls: SimpleQueue[bytes]) -> None:
    """Put each received call into the queue. If the parent closes the link, exit at once, even during a call."""
    with suppress(OSError, EOFError):
        while True:
            (size,) = CALL_SIZE.unpack(_receive_exactly(link, CALL_SIZE.size))
            calls.put(_receive_exactly(link, size))
    os._exit(1)


def _receive_exactly(link: socket, size: int) -> bytes:
    """Return ``size`` bytes of the link. Raises EOFError at its end.

    A file object of the link would keep it open in a process that the app forks.
    """
    received = bytearray()
    while len(received) < size:
        chunk = link.recv(min(size - len(received), _CHUNK_BYTES))
        if not chunk:
            raise EOFError
        received += chunk
    return bytes(received)


def _run_call(call: bytes) -> bytes:
    try:
        function, arguments = pickle.loads(call)  # noqa: S301  from the parent of this process
        return write_reply(function(*arguments))
    except RobotcoreError as error:
        with suppress(TypeError, ValueError):  # an attribute that JSON cannot hold
            return write_reply(error=error)
        return write_reply(error=RobotcoreError(str(error)))
    except Exception as error:  # noqa: BLE001  the function or the JSON encoder raised it
        return write_reply(error=RobotcoreError(f"{type(error).__name__}: {error}"))


def write_reply(result: Any = None, error: RobotcoreError | None = None) -> bytes:
    """Return the line that replies to a call with a result or an error. `read_reply` reads it.

    Raises TypeError or ValueError if JSON cannot represent the result or the error.

    >>> read_reply(write_reply([1, "a"]))
    ([1, 'a'], None)
    """
    return json.dumps({"result": result, "error": error}, default=_encode_error).encode() + b"\n"


def read_reply(line: bytes) -> tuple[Any, RobotcoreError | None]:
    """Return the result and the error in a line of `write_reply`. The error is None if the call succeeded.

    Raises ValueError if the line is not a reply.
    """
    try:
        reply = json.loads(line, object_hook=_decode_error)
        result, error = reply["result"], reply["error"]
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError) as problem:
        raise ValueError(f"{type(problem).__name__}: {problem}") from problem
    return result, error if isinstance(error, RobotcoreError) else None


def _encode_error(value: object) -> dict[str, Any]:
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
        raise TypeError(f"{name} is not an error class of robotcore")
    error = kind.__new__(kind)
    error.args = tuple(arguments)
    for key, value in state.items():
        if key in _ERROR_ATTRIBUTES or not hasattr(kind, key):
            error.__dict__[key] = value
    return error
