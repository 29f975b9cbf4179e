"""Handles the signals that end or suspend the program."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType, TracebackType
from typing import Any, NoReturn

from robotcore.errors import Interrupted, RobotcoreError
from robotcore.system import HAS_POSIX

LAST_SIGNAL = 3
"""The third signal in a run ends the process at once."""

WATCHDOG_SIGNAL: int | None = getattr(signal, "SIGURG", None)
"""The signal with which the watchdog interrupts a waiting call. Without a handler, the system ignores it.

Windows lacks it. There the watchdog raises SIGINT, the only signal that ends a wait.
"""

_ENDING = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK")
END_SIGNALS = [getattr(signal, name) for name in _ENDING if hasattr(signal, name)]
SUSPEND: int | None = getattr(signal, "SIGTSTP", None)
"""The signal that Ctrl-Z sends. None on systems without it."""


class WatchdogInterrupt(BaseException):
    """Interrupts the run's thread after the watchdog has tripped the latch.

    The latch contains the error that ends the run.
    """


@dataclass
class WatchdogSigint:
    """Whether the next SIGINT is the watchdog's, on a system without `WATCHDOG_SIGNAL`."""

    is_expected: bool = False


def end_by_signal(number: int) -> NoReturn:
    """End the process by the default action of a signal.

    The parent process then sees the signal's number, so that a loop in a shell script ends too
    (https://www.cons.org/cracauer/sigint.html). A shell reports the status 128 + ``number``, and `subprocess` reports
    ``-number``. On Windows the process exits with 128 + ``number``, because a signal does not end a process there.
    """
    if HAS_POSIX:
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)
    os._exit(128 + number)


def raise_again(number: int) -> NoReturn:
    """Send a signal that a `SignalGuard` has handled to the handler of the program.

    If the handler returns, KeyboardInterrupt is raised after SIGINT, and Interrupted after another signal.
    """
    try:
        signal.raise_signal(number)
    except KeyboardInterrupt:
        raise KeyboardInterrupt from None
    raise (KeyboardInterrupt if number == signal.SIGINT else Interrupted(number)) from None


class SignalGuard:
    """A context in which a signal such as SIGINT or SIGTERM raises Interrupted in the main thread.

    After a call of `mask`, signals are ignored, so that the stop of the motors is not interrupted. SIGHUP and SIGQUIT
    are ignored if the program was started so, for example by ``nohup``. A context in another thread handles no signals,
    because Python delivers signals only to the main thread.

    Python discards an exception that is raised in a callback of a weak reference or in ``__del__``, for example during
    an import. So the context raises Interrupted at its beginning if an outer context has had a signal, unless `mask`
    was called before: the close of a robot must begin also after a signal.
    """

    def __init__(self) -> None:
        self._thread = threading.get_ident()
        self._is_masked = self._is_deferred = self._is_last_masked = False
        self.raised: Interrupted | None = None
        """The exception of the last signal."""
        self.last: int | None = None
        """The number of the last signal, also of an ignored one."""
        self.last_resort: Callable[[], object] = lambda: None
        """Called at the third signal, before the process ends. An app may catch the exceptions of the first two."""
        self.before_suspension: Callable[[], object] = lambda: None
        """Called before the program is suspended (Ctrl-Z)."""
        self.after_suspension: Callable[[], object] = lambda: None
        """Called after the suspended program continues."""
        self.is_suspension_deferred = False
        """Whether a suspension waits for the next call of `check`."""
        self.count = 0
        """The number of signals in this context and in the contexts inside it."""
        self._before: dict[int, Any] = {}
        self._suspension = 0
        self.watchdog_sigint = WatchdogSigint()
        """The state that nested contexts share, because any of them may handle the signal."""

    def mask(self, *, but_last: bool = False) -> None:
        """Ignore all further signals. A run calls this before it closes the robot.

        but_last: whether the third signal still ends the process. A command sets it before it writes its result,
            because a full pipe or a paused terminal blocks the write.
        """
        self._is_masked, self._is_last_masked = True, not but_last
        self.is_suspension_deferred = False

    def reset(self) -> None:
        """Delete the signals that have arrived, and the mask, so that the program continues after them."""
        self.raised = self.last = None
        self.count = self._suspension = 0
        self._is_masked = self._is_last_masked = False

    @contextmanager
    def defer(self) -> Iterator[None]:
        """Return a context in which no signal raises an exception.

        A signal in the context raises Interrupted at the end of the context, also in place of another exception. A
        third signal still ends the process at once.
        """
        self._is_deferred = True
        try:
            yield
        finally:
            self._is_deferred = False
            self.check()

    def check(self) -> None:
        """Raise the exception of the last signal again, if there was a signal. Otherwise do a deferred suspension.

        An app may have caught the exception before.
        """
        if self.raised:
            raise self.raised
        if number := self._suspension:
            self._suspension = 0
            self._suspend(number)

    def interrupt_main_thread(self) -> None:
        """Raise WatchdogInterrupt in the main thread, also in a call that waits. The watchdog's thread calls this.

        After a call of `mask`, or if the guard was created in another thread, this does nothing.
        """
        if self._before and not self._is_masked:
            if HAS_POSIX:
                assert WATCHDOG_SIGNAL
                signal.pthread_kill(self._thread, WATCHDOG_SIGNAL)
            else:
                self.watchdog_sigint.is_expected = True
                signal.raise_signal(signal.SIGINT)

    def __enter__(self) -> SignalGuard:
        self._before = {}
        if threading.current_thread() is threading.main_thread():
            if outer := _find_active_guard():
                self.watchdog_sigint = outer.watchdog_sigint
                if not self._is_masked:
                    outer.check()
            handlers = {
                **dict.fromkeys(END_SIGNALS, self._raise),
                WATCHDOG_SIGNAL: self._interrupt,
                SUSPEND: self._on_suspend,
            }
            handled = {number: handler for number, handler in handlers.items() if number and _is_handled(number)}
            self._before = {number: signal.signal(number, handler) for number, handler in handled.items()}
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        if outer := _find_active_guard():
            outer.count += self.count
        is_foreign = isinstance(error, Exception) and not isinstance(error, RobotcoreError)
        if self.raised and is_foreign and not self._is_masked:
            raise self.raised  # native code, such as pydantic's, raises an error of its own in its place

    def _raise(self, number: int, frame: FrameType | None) -> None:
        if number == signal.SIGINT and self.watchdog_sigint.is_expected:
            self.watchdog_sigint.is_expected = False
            self._interrupt(number, frame)
            return
        self.count += 1
        self.last = number
        is_last = self.count >= LAST_SIGNAL and not self._is_last_masked
        if self._is_masked and not is_last:
            return
        self.raised = Interrupted(number)
        if is_last:
            self._end(number)
        if not self._is_deferred:
            raise self.raised

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        if not self._is_masked:
            raise WatchdogInterrupt

    def _on_suspend(self, number: int, frame: FrameType | None) -> None:
        if self.is_suspension_deferred:
            self._suspension = number
        elif not self._is_masked:  # the robot is not being closed
            self._suspend(number)

    def _suspend(self, number: int) -> None:
        self.before_suspension()
        if callable(outer := self._before[number]):
            outer(number, None)
        else:
            own = signal.signal(number, signal.SIG_DFL)
            try:
                signal.raise_signal(number)  # the program is suspended in this call, and continues in it
            finally:  # another signal may interrupt the program as soon as it continues
                signal.signal(number, own)
        self.after_suspension()

    def _end(self, number: int) -> NoReturn:
        self.mask()
        try:
            self.last_resort()
        finally:
            end_by_signal(number)


def _find_active_guard() -> SignalGuard | None:
    owner = getattr(signal.getsignal(signal.SIGINT), "__self__", None)
    return owner if isinstance(owner, SignalGuard) else None


def _is_handled(number: int) -> bool:
    # SIGINT and SIGTERM are always handled. Another signal is not, if the program was started to ignore it.
    return number in (signal.SIGINT, signal.SIGTERM) or signal.getsignal(number) is not signal.SIG_IGN
