"""Threads and memory that a run reserves before anything moves. Later the system may refuse both to a stop."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from queue import SimpleQueue
from threading import Lock
from typing import TYPE_CHECKING, TypeVar

from robotcore.errors import ResourceError
from robotcore.threads import is_out_of_memory, start_thread

if TYPE_CHECKING:
    from robotcore.hal.clock import Clock


T = TypeVar("T")

THREAD = "reserve"
"""The name of the threads."""

MEMORY_BYTES = 32 << 20
"""The size of the reserved memory. It takes address space only: pages that nothing writes need no memory."""


class BackgroundCall:
    """A call that may hang, run in another thread."""

    def __init__(self, function: Callable[[], object], clock: Clock) -> None:
        self.failure: BaseException | None = None
        """The exception that the call raised, if it raised one."""
        self._function, self._clock = function, clock
        self._begun = clock.now()
        self._is_made = self._is_over = False
        self._running = Lock()  # not an Event: if set() runs out of memory, an Event keeps its inner lock for ever
        self._running.acquire()

    @property
    def is_under_way(self) -> bool:
        return not self._is_over

    def is_done_within(self, limit_s: float) -> bool:
        """Wait for the end of the call, at most until ``limit_s`` seconds after its begin. Return whether it ended."""
        left_s = max(0.0, self._begun + limit_s - self._clock.now())
        if not self._is_over and self._running.acquire(timeout=left_s):
            self._running.release()
        return self._is_over

    def run(self) -> None:
        """Make the call in this thread. A second `run` does not repeat it; it only marks the end."""
        try:
            if not self._is_made:
                self._is_made = True
                self._function()
        except BaseException as failure:  # noqa: BLE001  the caller reads it from failure
            self.failure = failure
        finally:
            if not self._is_over:
                self._is_over = True
                self._running.release()


class Reserve:
    """Threads that wait for calls, and memory. A run holds both from before anything moves, for its stops.

    >>> from robotcore.hal.wall_clock import MonotonicClock
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
        self._idle = deque[str]()  # not a lock: a signal handler may interrupt a call and make another
        self._is_closed = False
        self._memory: bytes | None = None

    def hold(self, threads: int) -> None:
        """Start ``threads`` more threads, and hold memory. Raises ResourceError if the system refuses one of them."""
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
            try:
                self._calls.put(call)
            except MemoryError:
                self._idle.append(THREAD)
                raise
        else:
            call.run()
        return call

    def retry_on_memory_error(self, function: Callable[[], T]) -> T:
        """Call a function; if it runs out of memory, release the memory held here and call it again."""
        try:
            return function()
        except Exception as error:
            if not is_out_of_memory(error):
                raise
            self.release_memory()
            return function()

    def release_memory(self) -> None:
        """Free the memory held here, for a stop or for the end of a run. May be called again."""
        self._memory = None

    def close(self) -> None:
        """End the threads and free the memory. A thread whose call hangs ends after that call. May be called again."""
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
        """Wait for calls and make them. A step that runs out of memory is repeated."""
        call: BackgroundCall | None = None
        is_needed = True
        while is_needed:
            try:
                call = call or self._calls.get()
                is_needed = call is not None and self._make(call)
                call = None
            except BaseException:  # noqa: BLE001, PERF203, S112  a thread that ended would be missing at the next stop
                continue

    def _make(self, call: BackgroundCall) -> bool:
        """Make a call. Return whether the thread waits for another one."""
        call.run()
        self._idle.append(THREAD)
        return not (self._is_closed and self._take_thread())
