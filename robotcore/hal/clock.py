"""The clocks of a robot, simulated time in steps, and periodic tasks."""

from __future__ import annotations

import heapq
import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable

from robotcore.errors import UsageError


class PeriodicTask(ABC):
    """Work that `Clock.every` repeats."""

    @abstractmethod
    def stop(self) -> None:
        """End the repetition. Wait for a call under way, for a limited time. May be called again."""


class SimulatedTask(PeriodicTask):
    """Runs in the thread that lets simulated time pass, exactly when it is due."""

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
"""The lowest rate of the steps of a stepped clock."""

_SAME = 1e-6
"""The relative tolerance for a time step that a server stores in single precision."""

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
        """Let time pass until ``deadline``, in seconds; return whether it was in the future."""

    @abstractmethod
    def call_at(self, deadline: float, callback: Callback) -> None:
        """Call ``callback`` once at ``deadline``, in seconds, also in the middle of a sleep."""

    def prepare_calls(self) -> None:  # noqa: B027  simulated time needs nothing
        """Start the thread that `call_at` needs, if any. Raises ResourceError if the system refuses it."""

    def every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        """Call ``work`` every ``period`` seconds until the returned task is stopped.

        In simulated time, the thread that sleeps calls it when it is due. Otherwise a thread called ``name`` calls it,
        so that a wait for hardware delays no other work. ``work`` handles its own errors; `sleep_until` raises others.
        """
        return SimulatedTask(self, period, work)

    def time_of(self, monotonic_s: float) -> float:
        """Return this clock's time for a time of CLOCK_MONOTONIC, such as the kernel's time of capture. In seconds.

        The result is never later than now. A simulator's clock returns now.
        """
        return self.now()

    @abstractmethod
    def close(self) -> None:
        """Drop all calls that are still due."""


class SteppedClock(Clock):
    """Simulated time in whole steps, taken only within `sleep_until`.

    A call of `call_at` interrupts a sleep exactly at its step.

    rate_hz: ticks per second.
    advance: makes the simulator take a number of steps.
    step_s: the simulator's own step in seconds, if it has one. Raises UsageError if a tick is no whole number of steps.

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
        """The step in seconds: 1 / (rate · ⌈240 / rate⌉), if the simulator has no step of its own."""
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
    """Return the number of a simulator's steps in a tick. Raises UsageError if it is no whole number."""
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
    """A clock that passes each call on to another clock."""

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
    """The clock of a loop. It stands still within a tick; a sleep begins the next tick."""

    def __init__(self, source: Clock) -> None:
        super().__init__(source)
        self._now = source.now()
        self.tick = 0

    def now(self) -> float:
        return self._now

    def tick_age(self) -> float:
        """Return the duration of the present tick in seconds. `now` does not show it."""
        return self._source.now() - self._now

    def sleep_until(self, deadline: float) -> bool:
        is_ahead = self._source.sleep_until(deadline)
        self._now = self._source.now()
        self.tick += 1
        return is_ahead


class AppClock(Clock):
    """The clock of an app. An app reads it; time passes only after the app's step has returned."""

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
        """Do nothing: the loop closes its clock."""
