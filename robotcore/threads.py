"""Starts threads, and recognises Pythons without threads and errors that mean that memory has run out."""

from __future__ import annotations

import sys
from collections.abc import Callable
from threading import Thread

from robotcore.errors import ResourceError


def is_out_of_memory(error: BaseException) -> bool:
    """Return whether an error or one of its causes means that memory has run out.

    Besides MemoryError, this is the RuntimeError that `threading` raises if it cannot allocate a lock.

    >>> is_out_of_memory(MemoryError()), is_out_of_memory(RuntimeError("can't allocate lock"))
    (True, True)
    """
    is_refusal = isinstance(error, MemoryError) or (type(error) is RuntimeError and "allocate lock" in str(error))
    return is_refusal or (error.__cause__ is not None and is_out_of_memory(error.__cause__))


def has_threads() -> bool:
    """Return whether this Python can start threads. In a web page it cannot, unless its build supports them.

    >>> has_threads()
    True
    """
    emscripten = getattr(sys, "_emscripten_info", None)
    return emscripten is None or bool(emscripten.pthreads)


class StoppingThread(Thread):
    """A thread that stops motors. `--rt` gives it a higher priority than the run's tick."""


def start_thread(target: Callable[[], object], name: str, *, stops_motors: bool = False) -> Thread:
    """Start a daemon thread and return it. Raises ResourceError if the operating system refuses the thread.

    stops_motors: whether to start a `StoppingThread`.
    """
    try:
        thread = (StoppingThread if stops_motors else Thread)(target=target, name=name, daemon=True)
        thread.start()
    except (RuntimeError, MemoryError) as error:
        raise ResourceError(f"the system refuses the thread {name!r}") from error
    return thread
