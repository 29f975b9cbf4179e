"""The e-stop in the terminal: the space bar."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from select import select
from threading import Event, RLock, Thread, main_thread
from typing import Any

from robotcore.runtime.observer import Run
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.threads import start_thread

KEY = b" "
HINT = "space: stop"
PRESSED = "the space bar was pressed in the terminal"
BUFFER = 64
CLOSING_S = 1.0
"""Nobody who closes this waits longer for the thread that listens."""

LOOK_S = 0.1
"""How often to look whether there is still somebody to listen for, and whether the terminal is ours."""


def can_listen() -> bool:
    """Return whether somebody can press keys: standard input is a terminal, and this job is in front of it."""
    if os.name != "posix" or sys.stdin is None or sys.stdin.closed or not sys.stdin.isatty():
        return False
    return _is_in_front(sys.stdin.fileno())


class EmergencyStopKey:
    """An observer: while a run lasts, the space bar is its e-stop; the terminal is then put back as it was.

    A key comes at once and is not shown (``cbreak``). The program may be suspended and go on, in front or behind; in
    the background it leaves the terminal alone, for its keys are somebody else's, and so it does while Python's own
    debugger asks there for a command. An app that reads the terminal gets what it reads.
    """

    def __init__(self) -> None:
        self._terminal = sys.stdin.fileno()
        self._before: list[Any] | None = None
        self._lock = RLock()
        self._run: Run | None = None
        self._is_over = Event()
        self._is_paused = False
        self._thread: Thread | None = None

    def hint(self) -> str:
        """Return what the key does, while the terminal is ours; else nothing, for it does nothing."""
        return HINT if self._before is not None and _is_in_front(self._terminal) else ""

    def begin(self, run: Run) -> None:
        self._run = run
        self._take()
        self._thread = start_thread(self._listen, "space bar")

    def tick(self, record: TickRecord) -> None:
        """Keys come between ticks too."""

    def end(self, result: RunResult) -> None:
        self.close()

    def close(self) -> None:
        """Listen no more, and put the terminal back. May be called again."""
        self._is_over.set()
        self.pause()
        if self._thread:
            self._thread.join(CLOSING_S)

    def pause(self) -> None:
        """Make the terminal again what it was, until it is to `go_on`."""
        import termios

        with self._lock, suppress(termios.error), _unstopped():
            self._is_paused = True
            if self._before is not None:
                termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._before)
                self._before = None

    def go_on(self) -> None:
        """Let keys come at once again, as soon as the terminal is ours."""
        self._is_paused = self._is_over.is_set()
        self._take()

    def _listen(self) -> None:
        with suppress(OSError), _unstopped(), _keys_of(self._terminal) as keys:  # a terminal that is gone
            while not self._is_over.is_set():
                if KEY in self._pressed(keys) and self._run:
                    self._run.emergency.press(PRESSED)

    def _pressed(self, keys: int) -> bytes:
        """Return the keys that were pressed, after a short while at most."""
        if not _is_in_front(self._terminal):
            self._is_over.wait(LOOK_S)
            return b""
        if _is_debugger_asking():
            self._lend()
            return b""
        self._take()
        is_there, _, _ = select([keys], [], [], LOOK_S)
        return _read(keys) if is_there and not self._is_over.is_set() else b""

    def _take(self) -> None:
        """Let keys come at once, where the terminal is ours and nobody paused this."""
        import termios
        import tty

        with self._lock, suppress(termios.error):
            if self._before is None and not self._is_paused and _is_in_front(self._terminal):
                self._before = termios.tcgetattr(self._terminal)
                tty.setcbreak(self._terminal, termios.TCSANOW)

    def _lend(self) -> None:
        """Leave the terminal alone until the debugger has its command."""
        was_paused = self._is_paused
        self.pause()
        while _is_debugger_asking() and not self._is_over.wait(LOOK_S):
            pass
        if not was_paused:
            self.go_on()


@contextmanager
def _keys_of(terminal: int) -> Iterator[int]:
    """Lend a descriptor that never waits for the keys of a terminal; the app's own reading is not changed by it."""
    keys = os.open(os.ttyname(terminal), os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY)
    try:
        yield keys
    finally:
        os.close(keys)


def _read(keys: int) -> bytes:
    """Return the keys that are there; those that others have taken, or are to have, are theirs."""
    with suppress(OSError):
        return os.read(keys, BUFFER)
    return b""


def _is_debugger_asking() -> bool:
    """Return whether the main thread is in Python's own debugger."""
    frame = sys._current_frames().get(main_thread().ident or 0)  # noqa: SLF001  the one way to see another thread
    while frame:
        if frame.f_globals.get("__name__") == "bdb":
            return True
        frame = frame.f_back
    return False


def _is_in_front(terminal: int) -> bool:
    with suppress(OSError):  # it is no terminal of ours
        return os.tcgetpgrp(terminal) == os.getpgrp()
    return False


@contextmanager
def _unstopped() -> Iterator[None]:
    """Let a thread of a job behind set the terminal too, and fail to read it: else the whole job would be stopped."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTTOU, signal.SIGTTIN])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
