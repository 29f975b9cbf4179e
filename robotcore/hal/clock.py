"""The interface of a robot's clock, the clocks of simulators and loops, and periodic tasks."""

from __future__ import annotations

import heapq
import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable

from robotcore.errors import UsageError


class PeriodicTask(ABC):
    """A function that `Clock.every` calls periodically."""

    @abstractmethod
    def stop(self) -> None:
        """End the periodic calls. Wait a limited time for a running call to return. A second `stop` does nothing."""


class SimulatedTask(PeriodicTask):
    """A periodic task in simulated time. It runs exactly on time, in the thread that lets the time pass."""

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
"""The lowest number of steps in a second that a stepped clock chooses."""

_SAME = 1e-6
"""The relative tolerance of a simulator's time step, because a server may store it in single precision."""

Callback = Callable[[], None]


class Clock(ABC):
    """The time of a robot, in seconds since it was opened.

    ``is_lockstep`` says whether time passes only within `sleep_until`.
    """

    is_lockstep: bool = True

    @abstractmethod
    def now(self) -> float:
        """Return the time in seconds."""

    @abstractmethod
    def sleep_until(self, deadline: float) -> bool:
        """Let time pass until ``deadline``, in seconds. Return False if ``deadline`` was already in the past."""

    @abstractmethod
    def call_at(self, deadline: float, callback: Callback) -> None:
        """Call ``callback`` once at the time ``deadline``, in seconds. The call may interrupt a sleep."""

    def prepare_calls(self) -> None:  # noqa: B027  simulated time needs nothing
        """Start the thread for `call_at`, if the clock needs one. Raises ResourceError if the system refuses it."""

    def every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        """Call ``work`` every ``period`` seconds until the returned task is stopped.

        In simulated time, ``work`` is called in the thread that sleeps. In real time, it is called in a thread of its
        own, so that waiting for hardware delays nothing else. If ``work`` raises, the next `sleep_until` raises the
        error.

        name: the name of that thread.
        """
        return SimulatedTask(self, period, work)

    def time_of(self, monotonic_s: float) -> float:
        """Convert a time of CLOCK_MONOTONIC to a time of this clock. Both are in seconds.

        For example, the kernel stamps a camera's frames with CLOCK_MONOTONIC. The result is at most the present time. A
        simulator's clock returns the present time.
        """
        return self.now()

    @abstractmethod
    def close(self) -> None:
        """Cancel all calls that have not been made yet."""


class SteppedClock(Clock):
    """The clock of a simulator. Time passes in whole simulation steps, and only within `sleep_until`.

    A callback of `call_at` is called between two steps, exactly at its time.

    rate_hz: the number of ticks in a second.
    advance: a function that makes the simulator take a number of steps.
    step_s: the time step that the simulator prescribes, in seconds. Raises UsageError if a tick is not a whole number
    of such steps.

    >>> clock = SteppedClock(20, advance=lambda steps: None)
    >>> clock.sleep_until(0.05), clock.now()
    (True, 0.05)
    """

    def __init__(self, rate_hz: float, advance: Callable[[int], None], step_s: float | None = None) -> None:
        if not (math.isfinite(rate_hz) and rate_hz > 0):
            raise UsageError(f"the rate is {rate_hz} Hz; it must be a positive number", kind="rate-not-positive")
        per_tick = math.ceil(MIN_PHYSICS_RATE_HZ / rate_hz) if step_s is None else _steps_in_a_tick(rate_hz, step_s)
        self.steps_per_second = rate_hz * per_tick
        self._advance = advance
        self._count = 0
        self._calls: list[tuple[int, int, Callback]] = []
        self._order = itertools.count()

    @property
    def step(self) -> float:
        """The time step in seconds. If the simulator prescribes none, it is 1 / (rate · ⌈240 / rate⌉)."""
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
    """Return the number of simulation steps in a tick. Raises UsageError if it is not a whole number."""
    steps = 1 / (rate_hz * step_s)
    fitting_hz = 1 / (max(round(steps), 1) * step_s)
    if steps < 1 - _SAME or abs(steps - round(steps)) > _SAME * steps:
        raise UsageError(
            f"a tick of 1/{rate_hz:g} s is no whole number of the simulator's steps of {step_s:g} s. "
            f"Take --rate {fitting_hz:g}, or set the simulator's time step to {1 / rate_hz:g} s",
            kind="rate-does-not-fit",
            rate_hz=fitting_hz,
        )
    return round(steps)


class ClockWrapper(Clock):
    """A clock that forwards each call to another clock. Subclasses change some calls."""

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
    """The clock of a loop. Its time stays the same within a tick. A sleep begins the next tick."""

    def __init__(self, source: Clock) -> None:
        super().__init__(source)
        self._now = source.now()
        self.tick = 0

    def now(self) -> float:
        return self._now

    def tick_age(self) -> float:
        """Return the time since the present tick began, in seconds. `now` always returns the time of its begin."""
        return self._source.now() - self._now

    def sleep_until(self, deadline: float) -> bool:
        is_ahead = self._source.sleep_until(deadline)
        self._now = self._source.now()
        self.tick += 1
        return is_ahead


class AppClock(Clock):
    """The clock that an app gets. The app can only read it. Time passes after the app's step has returned."""

    def __init__(self, ticks: TickClock) -> None:
        self._ticks = ticks
        self.is_lockstep = ticks.is_lockstep

    def now(self) -> float:
        return self._ticks.now()

    def sleep_until(self, deadline: float) -> bool:
        raise UsageError(
            "an app never sleeps. Return Status.RUNNING from step, and the next tick comes by itself", kind="app-sleeps"
        )

    def call_at(self, deadline: float, callback: Callback) -> None:
        raise UsageError(
            "an app is not called back. Compare robot.clock.now() in step with the time to wait for",
            kind="app-wants-call",
        )

    def every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        raise UsageError("an app polls nothing. Do it in step, which is called once a tick", kind="app-polls")

    def close(self) -> None:
        """Do nothing, because the loop closes the real clock."""
