"""Handle the signals that end or suspend the program."""

from __future__ import annotations

import ctypes
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType, TracebackType
from typing import Any, NoReturn

from robotcore.errors import Interrupted

LAST_SIGNAL = 3
"""This signal in a row ends the process at once."""

WATCHDOG_SIGNAL: int = getattr(signal, "SIGURG", signal.SIGINT)
"""The watchdog interrupts a waiting call with it. Without a handler it does nothing."""

END_SIGNALS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT") if hasattr(signal, name)]
SUSPEND: int | None = getattr(signal, "SIGTSTP", None)
"""The signal of Ctrl-Z; None on systems without it."""


class WatchdogInterrupt(BaseException):
    """Raised in the run's thread after the watchdog tripped the latch. The latch has the error that ended the run."""


def end_by_signal(number: int) -> NoReturn:
    """End the process by a signal's default action.

    The parent process then sees the signal instead of an exit status, so a loop in a shell ends too
    (https://www.cons.org/cracauer/sigint.html). A shell reports it as 128 + ``number``, `subprocess` as ``-number``.
    If the signal does not end the process, for example on Windows, it exits with 128 + ``number``.
    """
    if os.name == "posix":
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)
    os._exit(128 + number)


class SignalGuard:
    """A context in which a signal raises Interrupted in the main thread.

    After `mask` no signal raises, so nothing interrupts the stopping of the motors. A signal that the program was
    started to ignore (``nohup``) is still ignored. Outside the main thread the context handles no signals, because
    Python delivers none there. A request to suspend the program (Ctrl-Z) is handled at once or at the next `check`,
    see `set_suspension_hooks`.
    """

    def __init__(self) -> None:
        self._thread = threading.get_ident()
        self._is_masked = self._is_deferred = self._is_interrupted = False
        self.raised: Interrupted | None = None
        """The exception of the last signal."""
        self._last_resort: Callable[[], object] = lambda: None
        self._count = 0
        self._before: dict[int, Any] = {}
        self._suspension = 0
        self._is_suspension_deferred = False
        self._before_suspension: Callable[[], object] = lambda: None
        self._after_suspension: Callable[[], object] = lambda: None

    @property
    def is_in_main_thread(self) -> bool:
        """Whether the guard was entered in the main thread, and so handles signals."""
        return bool(self._before)

    def mask(self) -> None:
        """Ignore all further signals, because the robot is being closed."""
        self._is_masked = True
        self._is_suspension_deferred = False
        if self._is_interrupted:
            _cancel_interrupt()

    @contextmanager
    def defer(self) -> Iterator[None]:
        """Return a context in which a signal raises only at the end. A third signal still ends the process."""
        self._is_deferred = True
        try:
            yield
        finally:
            self._is_deferred = False
        self.check()

    def set_last_resort(self, last_resort: Callable[[], object]) -> None:
        """Set the function that the third signal calls before it ends the process. An app may catch the others."""
        self._last_resort = last_resort

    def set_suspension_hooks(
        self,
        before: Callable[[], object],
        after: Callable[[], object] = lambda: None,
        *,
        is_deferred: bool = False,
    ) -> None:
        """Set the functions to call around a suspension of the program.

        before, after: called before and after it.
        is_deferred: suspend the program at the next `check`, not at once.
        """
        self._before_suspension, self._after_suspension, self._is_suspension_deferred = before, after, is_deferred

    def check(self) -> None:
        """Raise the last signal again if an app caught it, and handle a deferred suspension."""
        if self.raised:
            raise self.raised
        if number := self._suspension:
            self._suspension = 0
            self._suspend(number)

    def interrupt_main_thread(self) -> None:
        """Raise WatchdogInterrupt in the thread that made this guard, unless it is masked. Called in another thread.

        Outside the main thread a call that waits cannot be interrupted; the exception is raised when the call returns.
        """
        if self._is_masked:
            return
        if self.is_in_main_thread:
            signal.pthread_kill(self._thread, WATCHDOG_SIGNAL)
        else:
            self._is_interrupted = True
            _raise_in(self._thread, WatchdogInterrupt)

    def __enter__(self) -> SignalGuard:
        if threading.current_thread() is threading.main_thread():
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

    def _raise(self, number: int, frame: FrameType | None) -> None:
        if self._is_masked:
            return
        self._count += 1
        self.raised = Interrupted(number)
        if self._count == LAST_SIGNAL:
            self._end(number)
        if not self._is_deferred:
            raise self.raised

    def _interrupt(self, number: int, frame: FrameType | None) -> None:
        if not self._is_masked:
            raise WatchdogInterrupt

    def _on_suspend(self, number: int, frame: FrameType | None) -> None:
        if self._is_suspension_deferred:
            self._suspension = number
        elif not self._is_masked:  # while the robot is closed, no suspension
            self._suspend(number)

    def _suspend(self, number: int) -> None:
        """Suspend the program, or call the handler that was installed before."""
        self._before_suspension()
        if callable(outer := self._before[number]):
            outer(number, None)
        else:
            own = signal.signal(number, signal.SIG_DFL)
            try:
                signal.raise_signal(number)  # the program is suspended here, and continues here
            finally:  # the continued program may be interrupted at once
                signal.signal(number, own)
        self._after_suspension()

    def _end(self, number: int) -> NoReturn:
        self._is_masked = True
        try:
            self._last_resort()
        finally:
            end_by_signal(number)


class _CancelInterrupt(BaseException):
    """Raised in place of a pending WatchdogInterrupt."""


def _raise_in(thread: int, kind: type[BaseException]) -> None:
    """Raise an exception in a thread, as soon as it executes Python code."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(kind))


def _cancel_interrupt() -> None:
    """Cancel the pending exception of this thread, by raising a harmless one in its place.

    Clearing a pending exception makes CPython 3.11 loop if a tracer is attached.
    """
    with suppress(_CancelInterrupt):
        _raise_in(threading.get_ident(), _CancelInterrupt)
        while True:
            pass


def _is_handled(number: int) -> bool:
    """Return whether to handle a signal. SIGINT and SIGTERM are handled even if they were ignored before."""
    return number in (signal.SIGINT, signal.SIGTERM) or signal.getsignal(number) is not signal.SIG_IGN
