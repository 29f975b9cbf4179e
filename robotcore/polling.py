"""Work that a driver does again and again beside the app: in a thread of its own, or pumped by simulated time."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

from robotcore.errors import BackendError
from robotcore.threads import start_thread

if TYPE_CHECKING:
    from robotcore.clock import Clock

STOPPING_S = 1.0
"""Work that hangs does not keep a device from being closed for longer."""


class Polling(ABC):
    """Work under way, of which `Clock.every` tells more."""

    @abstractmethod
    def stop(self) -> None:
        """Begin it no more, and wait for what is under way, but not for ever. May be called again."""


class Pumped(Polling):
    """Done by whoever lets time pass, exactly when it is due."""

    def __init__(self, clock: Clock, period: float, work: Callable[[], object]) -> None:
        self._clock, self._period, self._work = clock, period, work
        self._due = clock.now()
        self._is_stopped = False
        self._wait()

    def stop(self) -> None:
        self._is_stopped = True

    def _wait(self) -> None:
        self._due += self._period
        self._clock.call_at(self._due, self._call)

    def _call(self) -> None:
        if not self._is_stopped:
            self._wait()
            self._work()


class Threaded(Polling):
    """Done by a thread; work that takes longer than the period begins again at once, and nothing is made up for."""

    def __init__(self, clock: Clock, period: float, work: Callable[[], object], name: str) -> None:
        self._clock, self._period, self._work = clock, period, work
        self._stopping = threading.Event()
        self._thread = start_thread(self._run, name)

    def stop(self) -> None:
        self._stopping.set()
        if self._thread is not threading.current_thread():
            self._thread.join(STOPPING_S)

    def _run(self) -> None:
        with suppress(BackendError):  # a server's time that fails is told to whoever sleeps by it
            due = self._clock.now() + self._period
            while not self._stopping.wait(max(0.0, due - self._clock.now())):
                self._work()
                due = max(due + self._period, self._clock.now())
