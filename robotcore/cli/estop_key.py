"""Make the space bar of the terminal the e-stop of a run."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from select import select
from threading import Event, RLock, Thread, main_thread
from typing import Any

from robotcore.cli.app_terminal import AppTerminal
from robotcore.cli.driving_keys import UPDATE_S, DrivingKeys
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.system import HAS_POSIX
from robotcore.threads import start_thread

KEY = b" "
HINT = "space: stop"
PRESS_REASON = "the space bar was pressed in the terminal"
BUFFER = 64
CLOSING_S = 1.0
"""The longest wait for the end of the thread that reads the keys, in seconds."""

POLL_S = 0.1
"""The thread checks at this interval whether the run has ended and whether the process is in the foreground."""


def can_listen() -> bool:
    """Return whether standard input is a terminal that has this process in its foreground."""
    if not HAS_POSIX or sys.stdin is None or sys.stdin.closed or not sys.stdin.isatty():
        return False
    return _is_in_foreground(sys.stdin.fileno())


NO_ESTOP_KEY_NOTE = "the space bar is no e-stop on this operating system. Ctrl-C ends the run and stops the motors"
"""The note of a run in a terminal whose keys this module cannot read."""


def is_estop_key_missing() -> bool:
    """Return whether a person sits at a terminal, but this operating system has no terminals of POSIX."""
    return not HAS_POSIX and sys.stdin is not None and not sys.stdin.closed and sys.stdin.isatty()


class EmergencyStopKey:
    """An observer that makes the space bar the e-stop of a run. It restores the terminal at the end.

    During the run the terminal is in ``cbreak`` mode, in which a key is read at once. The terminal returns to its
    former mode while the process is in the background or suspended. An `AppTerminal` stands in for standard input, and
    passes on every other key to an app that reads. While Python's debugger is active, it passes on the space bar too.

    has_driving_keys: whether the other keys drive the robot, in a run with an operator. The app then gets no keys.
    """

    def __init__(self, *, has_driving_keys: bool = False) -> None:
        self._stdin = self._terminal = sys.stdin.fileno()
        self._app: AppTerminal | None = None
        self._saved_mode: list[Any] | None = None
        self._lock = RLock()
        self._run: RunContext | None = None
        self._has_driving_keys = has_driving_keys
        self._interval = UPDATE_S if has_driving_keys else POLL_S
        self._driving_keys: DrivingKeys | None = None
        self._has_ended = Event()
        self._is_paused = False
        self._thread: Thread | None = None

    def get_hint(self) -> str:
        """Return the hint for the user, or an empty text while the key does not work."""
        if self._saved_mode is None or not _is_in_foreground(self._terminal):
            return ""
        return f"{self._driving_keys.hint}  {HINT}" if self._driving_keys else HINT

    def begin(self, run: RunContext) -> None:
        import termios

        self._run = run
        if self._has_driving_keys and run.operator:
            self._driving_keys = DrivingKeys(run.operator, run.robot.drive)
        try:
            keys = _open_non_blocking(self._terminal)
        except OSError:  # the terminal has vanished, or has no name here
            self.close()
            return
        with suppress(OSError, termios.error):  # without a pseudo-terminal the e-stop key must still work
            self._app = AppTerminal(self._stdin, self._saved_mode or termios.tcgetattr(self._terminal))
            self._terminal = self._app.real
        self._set_cbreak_mode()
        self._thread = start_thread(partial(self._listen, keys, self._app), "space bar")

    def tick(self, record: TickRecord) -> None:
        """Do nothing: a thread reads the keys."""

    def end(self, result: RunResult) -> None:
        self.close()

    def close(self) -> None:
        """Stop reading keys, and restore the terminal. Later calls do nothing."""
        self._has_ended.set()
        self.pause()
        if self._thread:
            self._thread.join(CLOSING_S)
        self._terminal = self._stdin
        if self._app:
            self._app.close()

    def pause(self) -> None:
        """Restore the terminal until `resume` is called. A robot that the keys drive stands."""
        import termios

        if self._driving_keys:
            self._driving_keys.stand()
        with self._lock, suppress(termios.error), _block_job_signals():
            self._is_paused = True
            if self._saved_mode is not None:
                termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._saved_mode)
                self._saved_mode = None

    def resume(self) -> None:
        """Read keys again as soon as the process is in the foreground."""
        self._is_paused = self._has_ended.is_set()
        self._set_cbreak_mode()

    def _listen(self, terminal: int, app: AppTerminal | None) -> None:
        sources = [terminal, app.output] if app else [terminal]
        with suppress(OSError), _block_job_signals():  # the terminal may vanish
            while not self._has_ended.is_set():
                self._handle_keys(self._read_keys(terminal, sources), app)
                if self._driving_keys:
                    self._driving_keys.update()
                if app:
                    _show(app.read_echo(), terminal)
        os.close(terminal)

    def _handle_keys(self, keys: bytes, app: AppTerminal | None) -> None:
        if not keys:
            return
        if not _is_debugger_active():
            if KEY in keys and self._run:
                self._run.emergency.press(PRESS_REASON)
            keys = keys.replace(KEY, b"")
            if self._driving_keys:
                self._driving_keys.press(keys)
                return
        if app:
            app.pass_on(keys)

    def _read_keys(self, terminal: int, sources: Sequence[int]) -> bytes:
        """Return the keys that were typed. Return early if there is an echo to show."""
        if not _is_in_foreground(self._terminal):
            self._has_ended.wait(self._interval)
            return b""
        self._set_cbreak_mode()
        ready, _, _ = select(sources, [], [], self._interval)
        return _read_available(terminal) if terminal in ready and not self._has_ended.is_set() else b""

    def _set_cbreak_mode(self) -> None:
        """Set ``cbreak`` mode, unless the process is in the background or the key is paused."""
        import termios
        import tty

        with self._lock, suppress(termios.error):
            if self._saved_mode is None and not self._is_paused and _is_in_foreground(self._terminal):
                self._saved_mode = termios.tcgetattr(self._terminal)
                tty.setcbreak(self._terminal, termios.TCSANOW)


def _open_non_blocking(terminal: int) -> int:
    """Open the terminal a second time, in non-blocking mode. The descriptor of stdin stays in blocking mode."""
    return os.open(os.ttyname(terminal), os.O_RDWR | os.O_NONBLOCK | os.O_NOCTTY)


def _read_available(terminal: int) -> bytes:
    """Return the keys that can be read without waiting. It is empty if another process has read them first."""
    with suppress(OSError):
        return os.read(terminal, BUFFER)
    return b""


def _show(echo: bytes, terminal: int) -> None:
    """Write the echo on the terminal. It is lost if the terminal accepts no output now."""
    with suppress(OSError):
        os.write(terminal, echo)


def _is_debugger_active() -> bool:
    frame = sys._current_frames().get(main_thread().ident or 0)  # noqa: SLF001  there is no other way to inspect a thread
    while frame:
        if frame.f_globals.get("__name__") == "bdb":
            return True
        frame = frame.f_back
    return False


def _is_in_foreground(terminal: int) -> bool:
    with suppress(OSError):  # the terminal belongs to another session
        return os.tcgetpgrp(terminal) == os.getpgrp()
    return False


@contextmanager
def _block_job_signals() -> Iterator[None]:
    """Block SIGTTOU and SIGTTIN. They would stop the whole job if it used the terminal from the background."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGTTOU, signal.SIGTTIN])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
