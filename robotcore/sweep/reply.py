"""The answer of a worker process to a call, as a line of JSON.

An app runs in the worker with all its rights, and may write to its pipe. Reading JSON runs no code, unlike a pickle.
"""

from __future__ import annotations

import json
from typing import Any

from robotcore import errors
from robotcore.errors import RobotcoreError

MAX_REPLY_BYTES = 64 * 2**20
"""The most bytes of a reply. The path of a run of a day and its picture are far below it."""

_ERROR = "robotcore.errors"
"""The key that tells an error from a mapping."""

_OWN = {"_told_traceback", "kind", "fields"}
"""The attributes of an error that its class gives a default. No other one replaces what the class defines, such as an
exit status."""


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
    return {_ERROR: [kind.__name__, arguments, state]}


def _decode_error(read: dict[str, Any]) -> Any:
    if _ERROR not in read:
        return read
    name, arguments, state = read[_ERROR]
    kind = getattr(errors, name)
    if not (isinstance(kind, type) and issubclass(kind, RobotcoreError)):
        raise TypeError(f"{name} is no error of robotcore")
    error = kind.__new__(kind)
    error.args = tuple(arguments)
    error.__dict__.update((key, value) for key, value in state.items() if key in _OWN or not hasattr(kind, key))
    return error
