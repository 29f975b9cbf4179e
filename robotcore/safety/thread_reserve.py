"""Threads and memory for the stops of motors. A run reserves them first, as the system may refuse them later."""

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
"""The name of the reserved threads."""

MEMORY_BYTES = 32 << 20
"""The size of the reserved memory, in bytes. It uses no RAM, because nothing is written to it."""


class BackgroundCall:
    """A call in another thread, because it may hang."""

    def __init__(self, function: Callable[[], object], clock: Clock) -> None:
        self.failure: BaseException | None = None
        """The exception that the call raised, if it raised one."""
        self._function, self._clock = function, clock
        self._begun = clock.now()
        self._is_made = self._is_over = False
        self._running = Lock()  # not an Event: its set() could run out of memory and never release its lock
        self._running.acquire()

    @property
    def is_under_way(self) -> bool:
        return not self._is_over

    def is_done_within(self, limit_s: float) -> bool:
        """Wait until the call ends, or until ``limit_s`` seconds after its beginning. Return whether it has ended."""
        left_s = max(0.0, self._begun + limit_s - self._clock.now())
        if not self._is_over and self._running.acquire(timeout=left_s):
            self._running.release()
        return self._is_over

    def run(self) -> None:
        """Make the call in this thread. A second `run` does not repeat it."""
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
    """Threads and memory that a run reserves before anything moves. It uses them to stop the motors.

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
        self._idle = deque[str]()  # not a lock, because a signal handler may interrupt `call` and use it too
        self._is_closed = False
        self._memory: bytes | None = None

    def hold(self, threads: int) -> None:
        """Start ``threads`` further threads, and reserve memory. Raises ResourceError if the system refuses either."""
        try:
            self._memory = self._memory or bytes(MEMORY_BYTES)
        except MemoryError as error:
            raise ResourceError(f"the system refuses {MEMORY_BYTES >> 20} MB of memory") from error
        for _ in range(threads):
            start_thread(self._work, THREAD, stops_motors=True)
            self._idle.append(THREAD)

    def call(self, function: Callable[[], object]) -> BackgroundCall:
        """Call a function in an idle thread. If none is idle, call it in this thread."""
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
        """Call a function. If it runs out of memory, release the reserved memory and call it again."""
        try:
            return function()
        except Exception as error:
            if not is_out_of_memory(error):
                raise
            self.release_memory()
            return function()

    def release_memory(self) -> None:
        """Free the reserved memory. A second call does nothing."""
        self._memory = None

    def close(self) -> None:
        """End the threads and free the memory. A thread with a running call ends after the call."""
        self._is_closed = True
        self.release_memory()
        while self._take_thread():
            self._calls.put(None)

    def _take_thread(self) -> bool:
        try:
            self._idle.pop()
        except IndexError:
            return False
        return True

    def _work(self) -> None:
        # A step that runs out of memory is repeated, because the next stop needs this thread.
        call: BackgroundCall | None = None
        is_needed = True
        while is_needed:
            try:
                call = call or self._calls.get()
                is_needed = call is not None and self._make(call)
                call = None
            except BaseException:  # noqa: BLE001, PERF203, S112  the next stop needs this thread
                continue

    def _make(self, call: BackgroundCall) -> bool:
        # Returns whether this thread waits for another call.
        call.run()
        self._idle.append(THREAD)
        return not (self._is_closed and self._take_thread())
