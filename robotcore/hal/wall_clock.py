"""Clocks that follow the machine's monotonic time. No other module reads that time."""

from __future__ import annotations

import heapq
import itertools
import math
import os
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import TypeVar

from robotcore.errors import BackendError
from robotcore.hal.clock import Callback, Clock, PeriodicTask
from robotcore.threads import is_out_of_memory, start_thread

__all__ = ["MonotonicClock", "ServerClock"]

T = TypeVar("T")

read_timer = time.perf_counter
"""Returns a time in seconds, from an arbitrary start, for the measurement of short durations."""

STOPPING_S = 1.0
"""The longest time, in seconds, that `ThreadedTask.stop` waits for a running call."""

_read_used_time = getattr(time, "thread_time", time.process_time)
"""Returns the processor time of the thread. A Python without threads has only the equal time of its process."""


class ThreadedTask(PeriodicTask):
    """A periodic task in its own thread. If a call takes longer than the period, the next call follows at once."""

    def __init__(self, clock: Clock, period: float, work: Callable[[], object], name: str) -> None:
        self._clock, self._period, self._work = clock, period, work
        self._stopping = threading.Event()
        self._thread = start_thread(self._run, name)

    def stop(self) -> None:
        self._stopping.set()
        if self._thread is not threading.current_thread():
            self._thread.join(STOPPING_S)

    def _run(self) -> None:
        with suppress(BackendError):  # `sleep_until` raises the error if a server's time cannot be read
            due = self._clock.now() + self._period
            while not self._stopping.wait(max(0.0, due - self._clock.now())):
                self._work()
                due = max(due + self._period, self._clock.now())


def read_idle_time() -> float:
    """Return the time in seconds, from an arbitrary start, in which the calling thread did not use a processor."""
    return time.monotonic() - _read_used_time()


def read_queue_time() -> float:
    """Return the time in seconds for which the calling thread has waited for a busy processor. 0 if it is unknown.

    Source: https://docs.kernel.org/scheduler/sched-stats.html, /proc/<pid>/schedstat.
    """
    try:
        file = os.open("/proc/thread-self/schedstat", os.O_RDONLY)
    except OSError:  # another system than Linux, or a kernel without these statistics
        return 0.0
    try:
        return int(os.read(file, 100).split()[1]) / 1e9
    finally:
        os.close(file)


MAX_WAIT_S = 0.1
"""The longest time, in seconds, that the thread of a `MonotonicClock` waits before it checks for due calls.

Memory may run out, so that a new call cannot wake the thread. Then the call is late by at most this time.
"""

WITHOUT_MEMORY_S = 0.005
"""The pause, in seconds, before a call that failed because memory had run out is repeated."""

CLOSING_S = 1.0
"""The longest time, in seconds, that `MonotonicClock.close` waits for a running call."""


class MonotonicClock(Clock):
    """A clock that follows the machine's time, and starts at zero. A thread of the clock makes the calls of `call_at`.

    The next `sleep_until` or `close` raises the exception of a call or of a periodic task. Later calls are still made.

    >>> clock = MonotonicClock()
    >>> clock.sleep_until(0.001), clock.now() >= 0.001
    (True, True)
    >>> clock.close()
    """

    is_lockstep = False
    _longest_nap = math.inf

    def __init__(self) -> None:
        self._start = time.monotonic()
        self._calls: list[tuple[float, int, Callback]] = []
        self._order = itertools.count()
        self._wake = threading.Condition()
        self._caller: threading.Thread | None = None
        self._failure: Exception | None = None
        self._is_closed = False

    def now(self) -> float:
        return time.monotonic() - self._start

    def sleep_until(self, deadline: float) -> bool:
        is_ahead = (left := deadline - self.now()) >= 0
        while left > 0 and not self._failure:
            time.sleep(min(left, self._longest_nap))
            left = deadline - self.now()
        self._raise_failure()
        return is_ahead

    def call_at(self, deadline: float, callback: Callback) -> None:
        with self._wake:
            heapq.heappush(self._calls, (deadline, next(self._order), callback))
            self._start_caller()
            self._wake.notify()

    def prepare_calls(self) -> None:
        with self._wake:
            self._start_caller()

    def call_every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        return ThreadedTask(self, period, partial(self._attempt, work), name)

    def time_of(self, monotonic_s: float) -> float:
        return min(monotonic_s - self._start, self.now())

    def close(self) -> None:
        with self._wake:
            self._is_closed = True
            self._wake.notify()
        if self._caller and self._caller is not threading.current_thread():
            self._caller.join(CLOSING_S)
        self._raise_failure()

    def _raise_failure(self) -> None:
        failure, self._failure = self._failure, None
        if failure:
            raise failure

    def _start_caller(self) -> None:
        if self._caller is None:
            self._caller = start_thread(self._call, "clock", stops_motors=True)

    def _call(self) -> None:
        try:
            while (callback := self._repeat_without_memory(self._wait_for_next)) is not None:
                self._attempt(partial(self._repeat_without_memory, callback))
        except Exception as failure:  # noqa: BLE001  `sleep_until` raises the error
            self._failure = failure

    def _repeat_without_memory(self, function: Callable[[], T]) -> T | None:
        # A call may stop the motors, so it must not be lost if memory runs out.
        while not self._is_closed:
            try:
                return function()
            except Exception as error:
                if not is_out_of_memory(error):
                    raise
            time.sleep(WITHOUT_MEMORY_S)
        return None

    def _attempt(self, callback: Callable[[], object]) -> None:
        try:
            callback()
        except Exception as failure:  # noqa: BLE001  `sleep_until` raises it
            self._failure = self._failure or failure

    def _wait_for_next(self) -> Callback | None:
        with self._wake:
            while not self._is_closed:
                left = self._calls[0][0] - self.now() if self._calls else MAX_WAIT_S
                if left <= 0:
                    return heapq.heappop(self._calls)[2]
                self._wake.wait(min(left, self._longest_nap, MAX_WAIT_S))
        return None


class ServerClock(MonotonicClock):
    """A clock that follows the time of a simulation server, and starts at zero.

    source: a function that returns the server's time in seconds.

    >>> clock = ServerClock(lambda: 12.5)  # the server's time stands still
    >>> clock.now()
    0.0
    >>> clock.close()
    """

    _longest_nap = 0.005

    def __init__(self, source: Callable[[], float]) -> None:
        super().__init__()
        self._source = source
        self._zero = source()

    def now(self) -> float:
        return self._source() - self._zero

    def time_of(self, monotonic_s: float) -> float:
        return self.now()
