"""Signals that end a program, as an exception that no app swallows."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any

from robotcore.errors import Interrupted


class Interrupts:
    """While entered, the first signal raises Interrupted where the program is; after `hold` none does.

    Later signals are ignored, so that nothing cuts short the stopping of the motors; so is a hang-up that the program
    was started to ignore (``nohup``). Does nothing outside the main thread, where Python delivers no signals.
    """

    def __init__(self) -> None:
        self._is_held = False
        self._before: dict[int, Any] = {}

    def hold(self) -> None:
        """From here on no signal raises: the robot is being closed."""
        self._is_held = True

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
        if not self._is_held:
            self._is_held = True
            raise Interrupted(number)


def _signals() -> list[int]:
    """Return the signals to hear, as many as this system has."""
    numbers: list[int] = [signal.SIGINT, signal.SIGTERM]
    if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:
        numbers.append(signal.SIGHUP)
    return numbers
