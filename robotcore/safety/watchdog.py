"""The watchdog: a thread that detects a hang of the loop's thread, in the app or in a driver."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from threading import Event, Thread, get_ident
from types import FrameType
from typing import NamedTuple, TypeVar

from robotcore.errors import RobotcoreError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.thread_reserve import Reserve
from robotcore.threads import start_thread

T = TypeVar("T")


class TimeLimit(NamedTuple):
    """The longest time that the loop's thread may spend in one activity."""

    limit_s: float
    error: Callable[[float, FrameType | None], RobotcoreError]
    """A function that returns the error. Its arguments are the limit in seconds and the thread's innermost frame."""
    grace_s: float
    """The time that the thread has to continue after the interruption, in seconds."""
    is_step: bool = False
    """Whether the activity is the app's step, of which the watchdog reports a long first tick."""


class ActivityMonitor:
    """Records the activity and the driver call of one thread: the thread that created the monitor."""

    __slots__ = ("activities", "activity", "call", "calls", "thread", "ticks")

    def __init__(self) -> None:
        self.thread = get_ident()
        self.activity: TimeLimit | None = None
        """The time limit of the present activity. None if the activity has no limit."""
        self.call: TimeLimit | None = None
        """The time limit of the present driver call. None outside of driver calls."""
        self.activities = 0
        """The number of activities that have begun. While it does not change, the thread is in the same activity."""
        self.calls = 0
        """The number of driver calls that have begun."""
        self.ticks = 0
        """The number of ticks that have begun."""

    def begin(self, activity: TimeLimit | None) -> None:
        """Record the beginning of an activity. ``activity`` is its time limit, or None for an activity without one."""
        self.activity = activity
        self.activities += 1

    def call_driver(self, call: TimeLimit, function: Callable[..., T], *args: object) -> T:
        """Call a driver's function and record the call. Calls by other threads are not recorded."""
        if get_ident() != self.thread:
            return function(*args)
        before, self.call = self.call, call
        self.calls += 1
        try:
            return function(*args)
        finally:
            self.call = before


PERIOD_S = 0.05
"""The planned time between two checks, in seconds."""

MAX_PASSED_S = 2 * PERIOD_S
"""The longest time that counts between two checks, in seconds.

The watchdog itself wakes up late if the process was suspended, or if a thread held the interpreter's lock.
"""

FIRST_TICK_S = 30.0
"""The least time limit in the first tick, in seconds. Nothing moves yet, and an app may import libraries."""

NOTICE_S = 3.0
"""The duration of a first tick that is reported, in seconds."""


class Watchdog:
    """Measures how long the loop's thread has been in one activity, and reports an exceeded time limit.

    A thread of its own does this from `start` to `close`, by the machine's clock. It calls the functions below.

    monitor: the record of the activity of the loop's thread.
    on_timeout: a function that gets the error of an exceeded limit. It stops the motors and interrupts the loop.
    end: a function that gets the error if the loop's thread does not continue within the grace time of its limit.
    reserve: the reserved memory. The watchdog releases it if the process has no other memory left.
    scale: a factor that multiplies every limit.
    report: a function that gets a note if the run goes on: about the first limit that is exceeded under a debugger or
    another tracer, and about a first tick that has lasted for `NOTICE_S`.
    long_s: a time in seconds after which an activity is long, and may go on.
    on_long: a function that is called at each check of a long activity.

    >>> timeout = Event()
    >>> monitor = ActivityMonitor()
    >>> monitor.ticks = 2
    >>> monitor.begin(TimeLimit(0.1, lambda seconds, frame: RobotcoreError("step hangs"), 1.0))
    >>> watchdog = Watchdog(monitor, lambda error: timeout.set(), print, Reserve(MonotonicClock()))
    >>> watchdog.start()
    >>> timeout.wait(10.0)
    True
    >>> watchdog.close()
    >>> watchdog
    Watchdog(timeout='step hangs')
    """

    def __init__(
        self,
        monitor: ActivityMonitor,
        on_timeout: Callable[[RobotcoreError], object],
        end: Callable[[RobotcoreError], object],
        reserve: Reserve,
        scale: float = 1.0,
        report: Callable[[str], object] = lambda _: None,
        long_s: float = inf,
        on_long: Callable[[], object] = lambda: None,
    ) -> None:
        self._monitor, self._on_timeout, self._end, self._scale = monitor, on_timeout, end, scale
        self._activity_timer, self._call_timer = _StallTimer(), _StallTimer()
        self._long_s, self._on_long = long_s, on_long
        self._timeout: _Timeout | None = None
        self._reserve, self._report = reserve, report
        self._has_reported_tracer = self._has_reported_first_tick = False
        self._is_closed = Event()
        self._thread: Thread | None = None

    def __repr__(self) -> str:
        return f"Watchdog(timeout={str(self._timeout.error) if self._timeout else None!r})"

    def start(self) -> None:
        """Start the thread. Raises ResourceError if the system refuses it."""
        self._thread = start_thread(self._watch, "watchdog", stops_motors=True)

    def close(self) -> None:
        """End the thread. A second call does nothing."""
        self._is_closed.set()
        if self._thread:
            self._thread.join()

    def _watch(self) -> None:
        clock, last = MonotonicClock(), 0.0
        while not self._is_closed.is_set():
            try:
                if not self._is_closed.wait(PERIOD_S):
                    now = clock.now()
                    passed_s, last = min(now - last, MAX_PASSED_S), now
                    self._check(passed_s)
            except Exception:  # noqa: BLE001, PERF203  without a watchdog a run that hangs never ends
                self._reserve.release_memory()

    def _check(self, passed_s: float) -> None:
        monitor = self._monitor
        call, activity = monitor.call, monitor.activity
        call_s = self._call_timer.advance(passed_s if call else 0.0, monitor.calls)
        activity_s = self._activity_timer.advance(0.0 if call else passed_s, monitor.activities)
        if (activity or call) and max(activity_s, call_s) > self._long_s:
            self._on_long()
        if self._timeout and self._timeout.activities == monitor.activities:
            self._wait_for_return(self._timeout, passed_s)
        elif call and call_s > self._limit_of(call):
            self._time_out(call)
        elif activity and activity_s > self._limit_of(activity):
            self._time_out(activity)
        elif activity and activity.is_step and monitor.ticks == 1 and activity_s > NOTICE_S:
            self._report_first_tick(activity)

    def _report_first_tick(self, activity: TimeLimit) -> None:
        if not self._has_reported_first_tick:
            self._has_reported_first_tick = True
            error = activity.error(NOTICE_S, self._get_frame())
            self._report(f"{error}. A first tick that lasts {self._limit_of(activity):g} s ends the run")

    def _limit_of(self, limit: TimeLimit) -> float:
        limit_s = max(limit.limit_s, FIRST_TICK_S) if self._monitor.ticks <= 1 else limit.limit_s
        return limit_s * self._scale

    def _time_out(self, limit: TimeLimit) -> None:
        frame = self._get_frame()
        error = limit.error(self._limit_of(limit), frame)
        if is_debugged(frame):
            if not self._has_reported_tracer:
                self._has_reported_tracer = True
                self._report(
                    f"the watchdog did not end the run, because a debugger or another tracer is active: {error}"
                )
            return
        self._timeout = _Timeout(error, self._monitor.activities, limit.grace_s)
        self._on_timeout(error)

    def _get_frame(self) -> FrameType | None:
        return sys._current_frames().get(self._monitor.thread)  # noqa: SLF001  Python offers no public function

    def _wait_for_return(self, timeout: _Timeout, passed_s: float) -> None:
        timeout.left_s -= passed_s
        if timeout.left_s < 0:
            timeout.left_s = inf
            self._end(timeout.error)


class _StallTimer:
    def __init__(self) -> None:
        self._count = -1
        self._seconds = 0.0

    def advance(self, passed_s: float, count: int) -> float:
        """Return the seconds for which ``count`` has not changed. ``passed_s`` is the time since the last call."""
        self._seconds = self._seconds + passed_s if count == self._count else 0.0
        self._count = count
        return self._seconds


@dataclass
class _Timeout:
    error: RobotcoreError
    activities: int
    """The number of activities at the time-out. If it has changed, the thread has continued."""
    left_s: float
    """The remaining time for the thread to continue, in seconds."""


def is_debugged(frame: FrameType | None) -> bool:
    """Return whether a debugger or another tracer follows a thread. A tool that measures coverage does not count.

    A tracer of `sys.settrace` is an attribute of the frames that it follows. Since Python 3.12, a debugger may be a
    tool of `sys.monitoring` instead.

    frame: the innermost frame of the thread.
    """
    monitoring = getattr(sys, "monitoring", None)
    if monitoring and monitoring.get_tool(monitoring.DEBUGGER_ID):
        return True
    while frame:
        if frame.f_trace and "coverage" not in type(getattr(frame.f_trace, "__self__", frame.f_trace)).__module__:
            return True
        frame = frame.f_back
    return False
