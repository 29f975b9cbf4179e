"""Time on a robot: stepped, monotonic or following, and the view of it that an app gets.

This is the one module that looks at the machine's own clock; everyone else is handed a `Clock`.
"""

from __future__ import annotations

import heapq
import itertools
import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import partial

from robotcore.errors import UsageError
from robotcore.polling import Polling, Pumped, Threaded
from robotcore.threads import is_out_of_memory, start_thread

MIN_PHYSICS_RATE_HZ = 240
"""A stepped clock never takes coarser steps than this."""

_SAME = 1e-6
"""By so much a time step that a server keeps in single precision may differ from what was meant."""

LONGEST_WAIT_S = 0.1
"""A call whose notice was lost, for want of memory, is late by no more than this."""

WITHOUT_MEMORY_S = 0.005

CLOSING_S = 1.0
"""A call that hangs does not keep a clock from being closed for longer."""

Callback = Callable[[], None]


class Clock(ABC):
    """Seconds since the robot was opened.

    ``is_lockstep`` is whether time passes only while somebody sleeps.
    """

    is_lockstep: bool = True

    @abstractmethod
    def now(self) -> float:
        """Return the time in seconds."""

    @abstractmethod
    def sleep_until(self, deadline: float) -> bool:
        """Let time pass until ``deadline``; return whether it was still ahead."""

    @abstractmethod
    def call_at(self, deadline: float, callback: Callback) -> None:
        """Call once when ``deadline`` has come, wherever the sleeper then is."""

    def prepare_calls(self) -> None:  # noqa: B027  simulated time needs nothing
        """Start what `call_at` needs, so that no later call is refused. Raises ResourceError if the system refuses."""

    def every(self, period: float, work: Callable[[], object], name: str) -> Polling:
        """Do ``work`` every ``period`` seconds from now on, until the polling is stopped.

        Where time is simulated, whoever lets it pass does it, when it is due; else a thread called ``name`` does, so
        that what waits for hardware holds up nobody. ``work`` deals with its own errors; what it raises all the same is
        raised to whoever lets time pass.
        """
        return Pumped(self, period, work)

    def time_of(self, monotonic_s: float) -> float:
        """Return this clock's time at a moment of CLOCK_MONOTONIC, in seconds: the kernel's stamps on what it captures.

        Never later than now. A simulator's time has nothing to do with the machine's: there, it is now.
        """
        return self.now()

    @abstractmethod
    def close(self) -> None:
        """Forget every call that is still to come."""


class SteppedClock(Clock):
    """Simulated time: a whole number of steps, taken only while somebody sleeps.

    ``advance(n)`` makes the simulator take n steps. Calls asked for by `call_at` cut a sleep
    exactly at their step. ``step_s`` is the step of a simulator that has one of its own, in seconds, and takes its
    finer physics steps by itself; raises UsageError where the tick is no whole number of them.
    """

    def __init__(self, rate_hz: float, advance: Callable[[int], None], step_s: float | None = None) -> None:
        if not (math.isfinite(rate_hz) and rate_hz > 0):
            raise UsageError(f"the rate is {rate_hz} Hz; it must be a positive number")
        per_tick = math.ceil(MIN_PHYSICS_RATE_HZ / rate_hz) if step_s is None else _steps_in_a_tick(rate_hz, step_s)
        self.steps_per_second = rate_hz * per_tick
        self._advance = advance
        self._count = 0
        self._calls: list[tuple[int, int, Callback]] = []
        self._order = itertools.count()

    @property
    def step(self) -> float:
        """In seconds: 1 / (rate · ⌈240 / rate⌉), a physics step, where the simulator has none of its own."""
        return 1 / self.steps_per_second

    def now(self) -> float:
        return self._count / self.steps_per_second

    def sleep_until(self, deadline: float) -> bool:
        target = round(deadline * self.steps_per_second)
        is_ahead = target >= self._count
        while self._calls and self._calls[0][0] <= target:
            at, _, callback = heapq.heappop(self._calls)
            self._step_to(at)
            callback()
        self._step_to(target)
        return is_ahead

    def call_at(self, deadline: float, callback: Callback) -> None:
        step = math.ceil(deadline * self.steps_per_second - 1e-6)
        heapq.heappush(self._calls, (step, next(self._order), callback))

    def close(self) -> None:
        self._calls.clear()

    def _step_to(self, count: int) -> None:
        if count > self._count:
            self._advance(count - self._count)
            self._count = count


def _steps_in_a_tick(rate_hz: float, step_s: float) -> int:
    """Return how many of a simulator's steps make a tick; raises UsageError where no whole number does."""
    steps = 1 / (rate_hz * step_s)
    fitting_hz = 1 / (max(round(steps), 1) * step_s)
    if steps < 1 - _SAME or abs(steps - round(steps)) > _SAME * steps:
        raise UsageError(
            f"a tick of 1/{rate_hz:g} s is no whole number of the simulator's steps of {step_s:g} s. "
            f"Take --rate {fitting_hz:g}, or set the simulator's time step to {1 / rate_hz:g} s"
        )
    return round(steps)


class MonotonicClock(Clock):
    """The machine's own time, from zero. Calls are made by a thread of the clock's.

    What a call or polled work raises there is raised again by the next `sleep_until`, or by `close`; later calls are
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

    def every(self, period: float, work: Callable[[], object], name: str) -> Polling:
        return Threaded(self, period, partial(self._attempt, work), name)

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
        except Exception as failure:  # noqa: BLE001  a server's time may fail; raised where somebody listens
            self._failure = failure

    def _insist(self, callback: Callback) -> None:
        """Make a call, again while memory runs out: it may be the one that stops the motors."""
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
        except Exception as failure:  # noqa: BLE001  raised where somebody listens
            self._failure = self._failure or failure

    def _next_due(self) -> Callback | None:
        """Wait for the next call, also if memory runs out: it may be the one that stops the motors."""
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


class FollowingClock(MonotonicClock):
    """The time of a server that runs by itself, from zero; ``source`` asks it."""

    _longest_nap = 0.005

    def __init__(self, source: Callable[[], float]) -> None:
        super().__init__()
        self._source = source
        self._zero = source()

    def now(self) -> float:
        return self._source() - self._zero

    def time_of(self, monotonic_s: float) -> float:
        return self.now()


class ClockOver(Clock):
    """Another clock's time."""

    def __init__(self, source: Clock) -> None:
        self._source = source
        self.is_lockstep = source.is_lockstep

    def now(self) -> float:
        return self._source.now()

    def sleep_until(self, deadline: float) -> bool:
        return self._source.sleep_until(deadline)

    def call_at(self, deadline: float, callback: Callback) -> None:
        self._source.call_at(deadline, callback)

    def prepare_calls(self) -> None:
        self._source.prepare_calls()

    def every(self, period: float, work: Callable[[], object], name: str) -> Polling:
        return self._source.every(period, work, name)

    def time_of(self, monotonic_s: float) -> float:
        return self._source.time_of(monotonic_s)

    def close(self) -> None:
        self._source.close()


class PacedClock(ClockOver):
    """A stepped clock held back to real time; where the machine is too slow, it is delayed."""

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


class TickClock(ClockOver):
    """The clock a loop ticks: it stands still within a tick, and a sleep begins the next one."""

    def __init__(self, source: Clock) -> None:
        super().__init__(source)
        self._now = source.now()
        self.tick = 0

    def now(self) -> float:
        return self._now

    def tick_age(self) -> float:
        """Return for how long the tick has lasted, in seconds: time that `now` does not show yet."""
        return self._source.now() - self._now

    def sleep_until(self, deadline: float) -> bool:
        is_ahead = self._source.sleep_until(deadline)
        self._now = self._source.now()
        self.tick += 1
        return is_ahead


class AppClock(Clock):
    """The clock an app sees. It can be read; time passes only when the app has returned from its step."""

    def __init__(self, ticks: TickClock) -> None:
        self._ticks = ticks
        self.is_lockstep = ticks.is_lockstep

    def now(self) -> float:
        return self._ticks.now()

    def sleep_until(self, deadline: float) -> bool:
        raise UsageError("an app never sleeps. Return Status.RUNNING from step, and the next tick comes by itself")

    def call_at(self, deadline: float, callback: Callback) -> None:
        raise UsageError("an app is not called back. Compare robot.clock.now() in step with the time to wait for")

    def every(self, period: float, work: Callable[[], object], name: str) -> Polling:
        raise UsageError("an app polls nothing. Do it in step, which is called once a tick")

    def close(self) -> None:
        """Leave the clock to those who tick it."""
