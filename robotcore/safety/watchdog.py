"""The watchdog: a thread that notices when the loop's thread does not come back, from the app or from a driver."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import inf
from threading import Event, Thread
from types import FrameType

from robotcore.errors import RobotcoreError
from robotcore.safety.fairness import FairTime
from robotcore.safety.reserve import Reserve
from robotcore.safety.whereabouts import Stay, Whereabouts
from robotcore.threads import start_thread

PERIOD_S = 0.05
FIRST_TICK_S = 30.0
"""Until the first tick has ended nothing moves, while libraries are imported and models loaded: it may take this."""


class Watchdog:
    """From `start` to `close`, looks where the loop's thread is, on the machine's time, whatever the robot's clock is.

    ``bite`` is called with the error where it stays too long: to stop the motors and call the thread back. Where it has
    not come back within its grace, ``end`` is called. Both in the watchdog's thread. ``patience`` makes every limit
    longer. ``reserve`` has the memory that it may need. While a debugger or another tracer follows the thread, nothing
    is too long: ``report_tracer`` is then called once, with the error that would have ended the run.
    """

    def __init__(
        self,
        where: Whereabouts,
        bite: Callable[[RobotcoreError], object],
        end: Callable[[RobotcoreError], object],
        reserve: Reserve,
        patience: float = 1.0,
        report_tracer: Callable[[RobotcoreError], object] = lambda _: None,
    ) -> None:
        self._where, self._bite, self._end, self._patience = where, bite, end, patience
        self._doing, self._call = _Standstill(), _Standstill()
        self._bitten: _Bitten | None = None
        self._reserve, self._report_tracer = reserve, report_tracer
        self._has_reported_tracer = False
        self._is_closed = Event()
        self._thread: Thread | None = None

    def start(self) -> None:
        """Begin to look. Raises ResourceError if the system refuses the thread."""
        self._thread = start_thread(partial(self._watch, FairTime(self._where.native_thread, PERIOD_S)), "watchdog")

    def close(self) -> None:
        """Look no more. May be called again."""
        self._is_closed.set()
        if self._thread:
            self._thread.join()

    def _watch(self, time: FairTime) -> None:
        while not self._is_closed.is_set():
            try:
                if not self._is_closed.wait(PERIOD_S):
                    self._look(time.passed())
            except Exception:  # noqa: BLE001, PERF203  without a watchdog, a run that hangs never ends
                self._reserve.release_memory()

    def _look(self, passed: float) -> None:
        """Take in where the thread is, and for how long it has been there."""
        where = self._where
        call, doing = where.call, where.doing
        in_call = self._call.after(passed if call else 0.0, where.calls)
        in_doing = self._doing.after(0.0 if call else passed, where.moves)
        if self._bitten and self._bitten.moves == where.moves:
            self._wait_for_it(self._bitten, passed)
        elif call and in_call > self._limit(call):
            self._catch(call, in_call)
        elif doing and in_doing > self._limit(doing):
            self._catch(doing, in_doing)

    def _limit(self, stay: Stay) -> float:
        limit = max(stay.limit_s, FIRST_TICK_S) if self._where.ticks <= 1 else stay.limit_s
        return limit * self._patience

    def _catch(self, stay: Stay, seconds: float) -> None:
        frame = sys._current_frames().get(self._where.thread)  # noqa: SLF001  the one way to see another thread
        error = stay.error(seconds, frame)
        if is_debugged(frame):
            if not self._has_reported_tracer:
                self._has_reported_tracer = True
                self._report_tracer(error)
            return
        self._bitten = _Bitten(error, self._where.moves, stay.grace_s)
        self._bite(error)

    def _wait_for_it(self, bitten: _Bitten, passed: float) -> None:
        bitten.left_s -= passed
        if bitten.left_s < 0:
            bitten.left_s = inf
            self._end(bitten.error)


class _Standstill:
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
class _Bitten:
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
