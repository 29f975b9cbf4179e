"""Threads and memory that a run sets aside while nothing moves: a system may refuse both when motors must stop."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from queue import SimpleQueue
from threading import Event, Thread
from typing import TYPE_CHECKING, TypeVar

from robotcore.errors import ResourceError

if TYPE_CHECKING:
    from robotcore.clock import Clock

T = TypeVar("T")

THREAD = "waits for a stop"

MEMORY_BYTES = 32 << 20
"""Address space alone: zeroed pages that nothing writes take no memory."""


def start_thread(target: Callable[[], object], name: str) -> Thread:
    """Start a daemon thread. Raises ResourceError if the system refuses one."""
    thread = Thread(target=target, name=name, daemon=True)
    try:
        thread.start()
    except RuntimeError as error:
        raise ResourceError(f"the system refuses the thread {name!r}") from error
    return thread


class BackgroundCall:
    """A call that may hang, run in another thread. ``failure`` is the exception that it raised, or None."""

    def __init__(self, function: Callable[[], object], clock: Clock) -> None:
        self.failure: Exception | None = None
        self._function, self._clock = function, clock
        self._begun, self._end = clock.now(), Event()

    @property
    def is_under_way(self) -> bool:
        return not self._end.is_set()

    def is_done_within(self, limit_s: float) -> bool:
        """Wait for the end, until ``limit_s`` seconds after the beginning; return whether it has come."""
        return self._end.wait(max(0.0, self._begun + limit_s - self._clock.now()))

    def run(self) -> None:
        """Make the call in the present thread."""
        try:
            self._function()
        except Exception as failure:  # noqa: BLE001  the caller asks for it
            self.failure = failure
        finally:
            self._end.set()


class Reserve:
    """Threads that wait for calls, and memory: what stopping needs, held from before anything moves.

    >>> from robotcore.clock import MonotonicClock
    >>> reserve = Reserve(MonotonicClock())
    >>> reserve.hold(threads=1)
    >>> call = reserve.call(lambda: print("stop"))
    >>> call.is_done_within(10.0)
    stop
    True
    >>> reserve.close()
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._calls = SimpleQueue[BackgroundCall | None]()
        self._idle = deque[str]()  # no lock: a signal's handler may call in the middle of a call
        self._is_closed = False
        self._memory: bytes | None = None

    def hold(self, threads: int) -> None:
        """Start this many threads more, and hold memory. Raises ResourceError if the system refuses one of them."""
        try:
            self._memory = self._memory or bytes(MEMORY_BYTES)
        except MemoryError as error:
            raise ResourceError(f"the system refuses {MEMORY_BYTES >> 20} MB of memory") from error
        for _ in range(threads):
            start_thread(self._work, THREAD)
            self._idle.append(THREAD)

    def call(self, function: Callable[[], object]) -> BackgroundCall:
        """Run a function in an idle thread, or in the caller's thread if none is idle."""
        call = BackgroundCall(function, self._clock)
        if self._take_thread():
            self._calls.put(call)
        else:
            call.run()
        return call

    def retry_on_memory_error(self, function: Callable[[], T]) -> T:
        """Call a function; if it runs out of memory, release the memory held here and call it again."""
        try:
            return function()
        except MemoryError:
            self.release_memory()
            return function()

    def release_memory(self) -> None:
        """Give back the memory held here, for a stop or for the end of a run. May be called again."""
        self._memory = None

    def close(self) -> None:
        """Give everything back. A thread whose call hangs ends after that call. May be called again."""
        self._is_closed = True
        self.release_memory()
        while self._take_thread():
            self._calls.put(None)

    def _take_thread(self) -> bool:
        """Take an idle thread for the next call. Return whether there was one."""
        try:
            self._idle.pop()
        except IndexError:
            return False
        return True

    def _work(self) -> None:
        while call := self._calls.get():
            call.run()
            del call  # what it raised holds its frames
            self._idle.append(THREAD)
            if self._is_closed and self._take_thread():
                return
