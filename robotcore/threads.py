"""Starts threads, and recognises the errors that the system raises when it refuses memory."""

from __future__ import annotations

from collections.abc import Callable
from threading import Thread

from robotcore.errors import ResourceError


def is_out_of_memory(error: BaseException) -> bool:
    """Return whether an error, or one of its causes, was raised because the system refused memory.

    `threading` raises a RuntimeError if it cannot allocate a lock.

    >>> is_out_of_memory(MemoryError()), is_out_of_memory(RuntimeError("can't allocate lock"))
    (True, True)
    """
    is_refusal = isinstance(error, MemoryError) or (type(error) is RuntimeError and "allocate lock" in str(error))
    return is_refusal or (error.__cause__ is not None and is_out_of_memory(error.__cause__))


def start_thread(target: Callable[[], object], name: str) -> Thread:
    """Start a daemon thread. Raises ResourceError if the system refuses one."""
    try:
        thread = Thread(target=target, name=name, daemon=True)
        thread.start()
    except (RuntimeError, MemoryError) as error:
        raise ResourceError(f"the system refuses the thread {name!r}") from error
    return thread
