"""Signals that end a program: first as an exception that no app swallows, at last as the end that a shell expects."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, NoReturn

from robotcore.errors import Interrupted

LAST_SIGNAL = 3


def die_of(number: int) -> NoReturn:
    """End the process by a signal's default action, after all that there was to tidy up.

    So whoever started it sees that it was interrupted: a loop in a shell ends too, which would go on after an exit
    status (https://www.cons.org/cracauer/sigint.html). A shell tells it as 128 + ``number``, `subprocess` as
    ``-number``. Where the signal does not end it, on Windows for one, it exits with 128 + ``number``.
    """
    if os.name == "posix":
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)
    os._exit(128 + number)


class Interrupts:
    """While entered, a signal raises Interrupted where the program is; after `hold` none does.

    So nothing cuts short the stopping of the motors. A hang-up that the program was started to ignore (``nohup``) is
    left alone. Does nothing outside the main thread, where Python delivers no signals.
    """

    def __init__(self) -> None:
        self._is_held = False
        self._raised: Interrupted | None = None
        self._last_resort: Callable[[], None] = lambda: None
        self._count = 0
        self._before: dict[int, Any] = {}

    def hold(self) -> None:
        """From here on no signal raises: the robot is being closed."""
        self._is_held = True

    def stop_with(self, last_resort: Callable[[], None]) -> None:
        """Let the third signal call this and end the process at once: an app may swallow what is raised."""
        self._last_resort = last_resort

    def check(self) -> None:
        """Raise again what an app has swallowed with a bare ``except``."""
        if self._raised:
            raise self._raised

    def __enter__(self) -> Interrupts:
        if threading.current_thread() is threading.main_thread():
            self._before = {number: signal.signal(number, self._raise) for number in _signals()}
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _raise(self, number: int, frame: FrameType | None) -> None:
        if self._is_held:
            return
        self._count += 1
        if self._count == LAST_SIGNAL:
            self._end(number)
        self._raised = Interrupted(number)
        raise self._raised

    def _end(self, number: int) -> NoReturn:
        self._is_held = True
        try:
            self._last_resort()
        finally:
            die_of(number)


def _signals() -> list[int]:
    """Return the signals to hear, as many as this system has."""
    numbers: list[int] = [signal.SIGINT, signal.SIGTERM]
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        numbers.append(signal.SIGHUP)
    return numbers
