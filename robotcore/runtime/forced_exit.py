"""The report of a run whose thread hangs. Other threads write it just before the process ends."""

from __future__ import annotations

import faulthandler
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from tempfile import TemporaryFile

from robotcore.runtime.observer import Observer, notify_end
from robotcore.runtime.result import RunResult
from robotcore.safety.thread_reserve import BackgroundCall, Reserve
from robotcore.system import HAS_POSIX

SHUTDOWN_GRACE_S = 0.2
"""The time limit on a forced exit for closing the robot, and for each function that gets the result, in seconds."""


class ForcedExit:
    """Writes texts and the result of a run, each in a reserved thread and with a time limit.

    observers: the observers of the run, which get the result first.
    on_forced_exit: a function that gets the result last.
    """

    def __init__(
        self, reserve: Reserve, observers: Sequence[Observer], on_forced_exit: Callable[[RunResult], object]
    ) -> None:
        self._reserve, self._observers, self._on_forced_exit = reserve, observers, on_forced_exit

    def write(self, text: bytes) -> BackgroundCall:
        """Write on standard error. A full pipe, or a terminal that is paused with Ctrl-S, blocks only the thread."""
        return self._reserve.call(partial(os.write, 2, text))

    def write_stacks(self) -> None:
        """Write the lines that all threads execute, if the system has memory and a pipe for them."""
        with suppress(OSError, MemoryError):
            self.write(_format_stacks()).is_done_within(SHUTDOWN_GRACE_S)

    def report(self, result: RunResult) -> None:
        """Give the result to the observers and to ``on_forced_exit``."""
        for receive in (partial(notify_end, self._observers), self._on_forced_exit):
            self._reserve.call(partial(receive, result)).is_done_within(SHUTDOWN_GRACE_S)


def print_reason(result: RunResult) -> None:
    """Print the reason of a forced exit on standard error.

    The text does not pass through ``sys.stderr``, because a thread that hangs may hold its lock.
    """
    os.write(2, f"error: {result.reason}\n".encode())


def _format_stacks() -> bytes:
    """Return the lines that all threads execute. Raises OSError if the system refuses a pipe.

    `faulthandler` holds the interpreter lock while it writes, so it writes to a pipe that never blocks. The pipe drops
    what does not fit. Windows has no such pipe, so it writes to a file there.
    """
    if not HAS_POSIX:
        with TemporaryFile() as file:
            faulthandler.dump_traceback(file)
            file.seek(0)
            return file.read()
    receiver, sender = os.pipe()
    try:
        os.set_blocking(sender, False)
        faulthandler.dump_traceback(sender)
    finally:
        os.close(sender)
    with os.fdopen(receiver, "rb") as pipe:
        return pipe.read()
