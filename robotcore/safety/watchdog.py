"""The watchdog: a thread that detects a loop thread that hangs, in the app or in a driver."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from math import inf
from pathlib import Path
from threading import Event, Thread, get_ident, get_native_id
from types import FrameType
from typing import NamedTuple, TypeVar

from robotcore.errors import RobotcoreError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.reserve import Reserve
from robotcore.threads import start_thread

T = TypeVar("T")
ArgumentT = TypeVar("ArgumentT")


class TimeLimit(NamedTuple):
    """Somewhere the thread should not be for longer than ``limit_s``.

    ``error`` makes the error of its having been there for so many seconds, given the thread's innermost frame.
    ``grace_s`` is how long the thread may take to come back when it was called back.
    """

    limit_s: float
    error: Callable[[float, FrameType | None], RobotcoreError]
    grace_s: float


class ActivityMonitor:
    """What the thread that made this is doing, and which driver's call it is in.

    ``moves`` grows with each change of ``doing``, ``calls`` with each call that is begun: where they stand still, so
    does the thread. ``ticks`` are those that were begun.
    """

    __slots__ = ("call", "calls", "doing", "moves", "native_thread", "thread", "ticks")

    def __init__(self) -> None:
        self.thread, self.native_thread = get_ident(), get_native_id()
        self.doing: TimeLimit | None = None
        self.call: TimeLimit | None = None
        self.moves = self.calls = self.ticks = 0

    def begin(self, doing: TimeLimit | None) -> None:
        """Note what the thread does from now on; None is not watched."""
        self.doing = doing
        self.moves += 1

    def call_driver(self, call: TimeLimit, function: Callable[[], T]) -> T:
        """Call a driver's function; what other threads do is not noted."""
        if get_ident() != self.thread:
            return function()
        before, self.call = self.call, call
        self.calls += 1
        try:
            return function()
        finally:
            self.call = before

    def call_driver_with(self, call: TimeLimit, function: Callable[[ArgumentT], T], argument: ArgumentT) -> T:
        """Call a driver's function with one argument. Two methods cost a third less than one with ``*args``."""
        if get_ident() != self.thread:
            return function(argument)
        before, self.call = self.call, call
        self.calls += 1
        try:
            return function(argument)
        finally:
            self.call = before


MAX_LATENESS = 2.0
"""Whoever looks this many times later than he meant to was held up himself: what is over that does not count."""


class RunnableTime:
    """Counts the seconds of a thread that is looked at every ``period_s``.

    What does not count: where the system tells (Linux), the time in which the thread was ready to run and had no
    processor, the second figure of ``schedstat`` (https://docs.kernel.org/scheduler/sched-stats.html); everywhere, the
    time for which whoever looks was held up, as he is when the process was suspended or another thread kept the
    interpreter's lock.
    """

    def __init__(self, native_thread: int, period_s: float) -> None:
        self._file = Path(f"/proc/self/task/{native_thread}/schedstat")
        self._longest = MAX_LATENESS * period_s
        self._wall = MonotonicClock()
        self._last = 0.0
        self._waited = self._waiting_time()

    def passed(self) -> float:
        """Return the seconds that count since this was last asked."""
        now = self._wall.now()
        elapsed, self._last = min(now - self._last, self._longest), now
        waiting = self._waiting_time()
        waited = max(0.0, min(waiting - self._waited, elapsed))
        self._waited += waited  # of a longer wait the rest counts next time
        return elapsed - waited

    def _waiting_time(self) -> float:
        """Return for how long the thread has waited for a processor in its life, in seconds."""
        with suppress(OSError, ValueError, IndexError):
            return int(self._file.read_text().split()[1]) * 1e-9
        return 0.0


PERIOD_S = 0.05
FIRST_TICK_S = 30.0
"""Until the first tick has ended nothing moves, while libraries are imported and models loaded: it may take this."""


class Watchdog:
    """Checks from `start` to `close`, by the machine's clock, how long the loop's thread has been in one place.

    where: the activity of the loop's thread.
    on_timeout: called with the error if a time limit is exceeded; it stops the motors and interrupts the thread.
    end: called if the thread has not continued within the limit's grace. Both are called in the watchdog's thread.
    scale: a factor on every limit.
    reserve: the memory that the watchdog may need.
    report_tracer: called once with the error if a limit is exceeded while a debugger or another tracer follows the
    thread. In that case the run goes on.
    """

    def __init__(
        self,
        where: ActivityMonitor,
        on_timeout: Callable[[RobotcoreError], object],
        end: Callable[[RobotcoreError], object],
        reserve: Reserve,
        scale: float = 1.0,
        report_tracer: Callable[[RobotcoreError], object] = lambda _: None,
    ) -> None:
        self._activity, self._on_timeout, self._end, self._scale = where, on_timeout, end, scale
        self._doing, self._call = _StallTimer(), _StallTimer()
        self._timeout: _Timeout | None = None
        self._reserve, self._report_tracer = reserve, report_tracer
        self._has_reported_tracer = False
        self._is_closed = Event()
        self._thread: Thread | None = None

    def start(self) -> None:
        """Begin to look. Raises ResourceError if the system refuses the thread."""
        self._thread = start_thread(
            partial(self._watch, RunnableTime(self._activity.native_thread, PERIOD_S)), "watchdog"
        )

    def close(self) -> None:
        """Look no more. May be called again."""
        self._is_closed.set()
        if self._thread:
            self._thread.join()

    def _watch(self, time: RunnableTime) -> None:
        while not self._is_closed.is_set():
            try:
                if not self._is_closed.wait(PERIOD_S):
                    self._look(time.passed())
            except Exception:  # noqa: BLE001, PERF203  without a watchdog, a run that hangs never ends
                self._reserve.release_memory()

    def _look(self, passed: float) -> None:
        """Take in where the thread is, and for how long it has been there."""
        where = self._activity
        call, doing = where.call, where.doing
        in_call = self._call.after(passed if call else 0.0, where.calls)
        in_doing = self._doing.after(0.0 if call else passed, where.moves)
        if self._timeout and self._timeout.moves == where.moves:
            self._wait_for_it(self._timeout, passed)
        elif call and in_call > self._limit(call):
            self._time_out(call, in_call)
        elif doing and in_doing > self._limit(doing):
            self._time_out(doing, in_doing)

    def _limit(self, stay: TimeLimit) -> float:
        limit = max(stay.limit_s, FIRST_TICK_S) if self._activity.ticks <= 1 else stay.limit_s
        return limit * self._scale

    def _time_out(self, stay: TimeLimit, seconds: float) -> None:
        frame = sys._current_frames().get(self._activity.thread)  # noqa: SLF001  the one way to see another thread
        error = stay.error(seconds, frame)
        if is_debugged(frame):
            if not self._has_reported_tracer:
                self._has_reported_tracer = True
                self._report_tracer(error)
            return
        self._timeout = _Timeout(error, self._activity.moves, stay.grace_s)
        self._on_timeout(error)

    def _wait_for_it(self, timeout: _Timeout, passed: float) -> None:
        timeout.left_s -= passed
        if timeout.left_s < 0:
            timeout.left_s = inf
            self._end(timeout.error)


class _StallTimer:
    """For how long something has not changed."""

    def __init__(self) -> None:
        self._seen = -1
        self._seconds = 0.0

    def after(self, passed: float, seen: int) -> float:
        """Return for how long it stands still, after so many seconds more."""
        self._seconds = self._seconds + passed if seen == self._seen else 0.0
        self._seen = seen
        return self._seconds


@dataclass
class _Timeout:
    """A thread that was called back, with so many seconds left for it."""

    error: RobotcoreError
    moves: int
    left_s: float


def is_debugged(frame: FrameType | None) -> bool:
    """Return whether a debugger follows a thread, given its innermost frame. Whoever measures coverage does not count.

    A tracer is set on the frames that it follows (`sys.settrace`); from Python 3.12 on it may be a tool of
    `sys.monitoring` instead.
    """
    monitoring = getattr(sys, "monitoring", None)
    if monitoring and monitoring.get_tool(monitoring.DEBUGGER_ID):
        return True
    while frame:
        if frame.f_trace and "coverage" not in type(getattr(frame.f_trace, "__self__", frame.f_trace)).__module__:
            return True
        frame = frame.f_back
    return False
