"""Time on a robot: the clock that apps and drivers are given, stepped time, and work that repeats."""

from __future__ import annotations

import heapq
import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable

from robotcore.errors import UsageError


class PeriodicTask(ABC):
    """Work under way, of which `Clock.every` tells more."""

    @abstractmethod
    def stop(self) -> None:
        """Begin it no more, and wait for what is under way, but not for ever. May be called again."""


class SimulatedTask(PeriodicTask):
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


MIN_PHYSICS_RATE_HZ = 240
"""A stepped clock never takes coarser steps than this."""

_SAME = 1e-6
"""By so much a time step that a server keeps in single precision may differ from what was meant."""

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

    def every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        """Do ``work`` every ``period`` seconds from now on, until the polling is stopped.

        Where time is simulated, whoever lets it pass does it, when it is due; else a thread called ``name`` does, so
        that what waits for hardware holds up nobody. ``work`` deals with its own errors; what it raises all the same is
        raised to whoever lets time pass.
        """
        return SimulatedTask(self, period, work)

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


class ClockWrapper(Clock):
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

    def every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        return self._source.every(period, work, name)

    def time_of(self, monotonic_s: float) -> float:
        return self._source.time_of(monotonic_s)

    def close(self) -> None:
        self._source.close()


class TickClock(ClockWrapper):
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

    def every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        raise UsageError("an app polls nothing. Do it in step, which is called once a tick")

    def close(self) -> None:
        """Leave the clock to those who tick it."""
