"""Clocks that follow the machine's time. No other module reads that time."""

from __future__ import annotations

import heapq
import itertools
import math
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial

from robotcore.errors import BackendError
from robotcore.hal.clock import Callback, Clock, ClockWrapper, PeriodicTask
from robotcore.threads import is_out_of_memory, start_thread

STOPPING_S = 1.0
"""The longest time in seconds for which stopping a periodic task waits for a call that hangs."""


class ThreadedTask(PeriodicTask):
    """A periodic task in its own thread. If a call takes longer than the period, the next call begins at once."""

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


LONGEST_WAIT_S = 0.1
"""The longest delay, in seconds, of a call whose notification was lost because memory ran out."""

WITHOUT_MEMORY_S = 0.005
"""The pause between two attempts of a call that fails because memory has run out, in seconds."""

CLOSING_S = 1.0
"""The longest time in seconds for which closing a clock waits for a call that hangs."""


class MonotonicClock(Clock):
    """A clock that follows the machine's time, and starts at zero. Its own thread makes the calls of `call_at`.

    If such a call or a periodic task raises an exception, the next `sleep_until` or `close` raises it. Later calls are
    still made.
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

    def every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
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
            self._caller = start_thread(self._call, "clock")

    def _call(self) -> None:
        try:
            while (callback := self._next_due()) is not None:
                self._attempt(partial(self._insist, callback))
        except Exception as failure:  # noqa: BLE001  `sleep_until` raises the error
            self._failure = failure

    def _insist(self, callback: Callback) -> None:
        """Make a call. Repeat it if it fails because memory runs out, because the call may stop the motors."""
        is_made = False
        while not (is_made or self._is_closed):
            try:
                callback()
                is_made = True
            except Exception as error:  # noqa: PERF203
                if not is_out_of_memory(error):
                    raise
                time.sleep(WITHOUT_MEMORY_S)

    def _attempt(self, callback: Callable[[], object]) -> None:
        try:
            callback()
        except Exception as failure:  # noqa: BLE001  `sleep_until` raises it
            self._failure = self._failure or failure

    def _next_due(self) -> Callback | None:
        """Wait for the next call that is due, and return it. None if the clock is closed.

        The wait goes on if memory runs out, because the call may stop the motors.
        """
        while True:
            try:
                return self._wait_for_next()
            except Exception as error:
                if not is_out_of_memory(error):
                    raise
            time.sleep(WITHOUT_MEMORY_S)

    def _wait_for_next(self) -> Callback | None:
        with self._wake:
            while not self._is_closed:
                left = self._calls[0][0] - self.now() if self._calls else LONGEST_WAIT_S
                if left <= 0:
                    return heapq.heappop(self._calls)[2]
                self._wake.wait(min(left, self._longest_nap, LONGEST_WAIT_S))
        return None


class ServerClock(MonotonicClock):
    """A clock that follows the time of a separate server, and starts at zero.

    source: the function that reads the server's time in seconds.
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


class PacedClock(ClockWrapper):
    """A simulated clock whose time passes no faster than real time. On a slow machine it passes more slowly."""

    def __init__(self, source: Clock) -> None:
        super().__init__(source)
        self._wall = MonotonicClock()
        self._delay = 0.0

    def sleep_until(self, deadline: float) -> bool:
        self._source.sleep_until(deadline)
        is_on_time = self._wall.sleep_until(deadline + self._delay)
        if not is_on_time:
            self._delay = self._wall.now() - deadline
        return is_on_time
