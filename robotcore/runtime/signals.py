"""Signals that end or suspend the program: raised as an exception, and passed on at the end."""

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

WATCHDOG_SIGNAL: int = getattr(signal, "SIGURG", signal.SIGINT)
"""It interrupts a call that waits, and does nothing where nobody hears it."""

ENDING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT") if hasattr(signal, name)]
SUSPEND: int | None = getattr(signal, "SIGTSTP", None)


class WatchdogInterrupt(BaseException):
    """Raised where the program is, by whoever has latched: the latch knows why the run ends."""


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


class SignalGuard:
    """While entered, a signal raises Interrupted where the program is; after `mask` none does.

    So nothing cuts short the stopping of the motors. A signal that the program was started to ignore (``nohup``) is
    left alone. Hears nothing outside the main thread, where Python delivers no signals. ``raised`` is the last one.

    A request to suspend the program (Ctrl-Z) is met at once, or at the next `check`, as `suspend_with` has it.
    """

    def __init__(self) -> None:
        self._thread = threading.get_ident()
        self._is_masked = self._is_deferred = self._is_interrupted = False
        self.raised: Interrupted | None = None
        self._last_resort: Callable[[], object] = lambda: None
        self._count = 0
        self._before: dict[int, Any] = {}
        self._suspension = 0
        self._is_to_wait = False
        self._before_suspension: Callable[[], object] = lambda: None
        self._after_suspension: Callable[[], object] = lambda: None

    @property
    def is_in_main_thread(self) -> bool:
        """Whether the guard was entered in the main thread, and so handles signals."""
        return bool(self._before)

    def mask(self) -> None:
        """From here on no signal raises: the robot is being closed."""
        self._is_masked = True
        self._is_to_wait = False
        if self._is_interrupted:
            _cancel_interrupt()

    @contextmanager
    def defer(self) -> Iterator[None]:
        """While entered, a signal waits, but for the third: what is done here is done wholly, and can be undone."""
        self._is_deferred = True
        try:
            yield
        finally:
            self._is_deferred = False
        self.check()

    def stop_with(self, last_resort: Callable[[], object]) -> None:
        """Let the third signal call this and end the process at once: an app may swallow what is raised."""
        self._last_resort = last_resort

    def suspend_with(
        self,
        before: Callable[[], object],
        after: Callable[[], object] = lambda: None,
        *,
        is_to_wait: bool = False,
    ) -> None:
        """Call ``before`` ere the program is suspended, at a `check` where that ``is_to_wait``, and ``after`` later."""
        self._before_suspension, self._after_suspension, self._is_to_wait = before, after, is_to_wait

    def check(self) -> None:
        """Raise again what an app has swallowed with a bare ``except``; be suspended where that was asked for."""
        if self.raised:
            raise self.raised
        if number := self._suspension:
            self._suspension = 0
            self._suspend(number)

    def interrupt_main_thread(self) -> None:
        """Raise WatchdogInterrupt, from another thread, in the thread that entered this, unless it is masked..

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
                **dict.fromkeys(ENDING, self._raise),
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
        if self._is_to_wait:
            self._suspension = number
        elif not self._is_masked:  # the robot is closed first
            self._suspend(number)

    def _suspend(self, number: int) -> None:
        """Suspend the program, or call the handler that was installed before."""
        self._before_suspension()
        if callable(outer := self._before[number]):
            outer(number, None)
        else:
            own = signal.signal(number, signal.SIG_DFL)
            try:
                signal.raise_signal(number)  # and here the program goes on, when somebody lets it
            finally:  # perhaps to hear that it is to end
                signal.signal(number, own)
        self._after_suspension()

    def _end(self, number: int) -> NoReturn:
        self._is_masked = True
        try:
            self._last_resort()
        finally:
            die_of(number)


class _CancelInterrupt(BaseException):
    """Raised in the place of what was not raised yet."""


def _raise_in(thread: int, kind: type[BaseException]) -> None:
    """Let an exception be raised in a thread when it next comes to Python's own code."""
    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(kind))


def _cancel_interrupt() -> None:
    """Let nothing be raised in this thread any more.

    CPython 3.11 goes on looking for what is not to be raised after all, and no tracer, a debugger's for one, comes past
    that; so another exception is raised in its place.
    """
    with suppress(_CancelInterrupt):
        _raise_in(threading.get_ident(), _CancelInterrupt)
        while True:
            pass


def _is_handled(number: int) -> bool:
    """Return whether to hear a signal: one that the program was started to ignore is left alone, but for two."""
    return number in (signal.SIGINT, signal.SIGTERM) or signal.getsignal(number) is not signal.SIG_IGN
