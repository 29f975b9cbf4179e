"""The interface of a robot's clock, and the clocks of simulators, of the control loop and of apps."""

from __future__ import annotations

import heapq
import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Callable

from robotcore.errors import UsageError

__all__ = ["Clock", "PeriodicTask", "SteppedClock"]


class PeriodicTask(ABC):
    """The repeated calls that `Clock.call_every` has started.

    >>> from robotcore.hal.clock import SteppedClock
    >>> clock, calls = SteppedClock(20, lambda steps: None), []
    >>> task = clock.call_every(0.1, lambda: calls.append(clock.now()), name="poll")
    >>> clock.sleep_until(0.2)
    True
    >>> task.stop()
    >>> clock.sleep_until(1.0), calls
    (True, [0.1, 0.2])
    """

    @abstractmethod
    def stop(self) -> None:
        """End the calls, and wait for a limited time until a running call returns. A second `stop` does nothing."""


class SimulatedTask(PeriodicTask):
    """A periodic task in simulated time. Each call is exactly on time, in the thread that calls `Clock.sleep_until`."""

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
"""The lowest rate of simulation steps that a `SteppedClock` chooses, in steps per second."""

_STEP_TOLERANCE = 1e-6
"""The relative tolerance of a simulator's time step, because a simulator may store the step in single precision."""

Callback = Callable[[], None]


class Clock(ABC):
    """The interface of a robot's clock. Its time is in seconds since the robot was opened.

    >>> from robotcore.hal.clock import SteppedClock
    >>> clock: Clock = SteppedClock(20, lambda steps: None)
    >>> clock.call_at(0.1, lambda: print("a call at", clock.now()))
    >>> clock.sleep_until(0.5)
    a call at 0.1
    True
    >>> clock
    <SteppedClock at 0.50 s>
    """

    is_lockstep: bool = True
    """Whether time passes only within `sleep_until`."""

    def __repr__(self) -> str:
        return f"<{type(self).__name__} at {self.now():.2f} s>"

    @abstractmethod
    def now(self) -> float:
        """Return the time in seconds since the robot was opened."""

    @abstractmethod
    def sleep_until(self, deadline: float) -> bool:
        """Wait until the clock shows ``deadline``, in seconds. Return False if ``deadline`` was already in the past."""

    @abstractmethod
    def call_at(self, deadline: float, callback: Callback) -> None:
        """Schedule one call of ``callback`` for the time ``deadline``, in seconds. The call may interrupt a sleep."""

    def prepare_calls(self) -> None:  # noqa: B027  simulated time needs nothing
        """Start the thread that makes the calls of `call_at`, if this clock has one.

        Raises ResourceError if the operating system refuses the thread.
        """

    def call_every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        """Call ``work`` every ``period`` seconds until the returned task is stopped.

        In simulated time, the thread that calls `sleep_until` calls ``work``. In real time, a separate thread calls
        ``work``, so that waiting for hardware delays nothing else. The next `sleep_until` raises the error that
        ``work`` has raised.

        name: the name of the separate thread.
        """
        return SimulatedTask(self, period, work)

    def time_of(self, monotonic_s: float) -> float:
        """Convert a time of CLOCK_MONOTONIC, such as the kernel's time stamp of a camera's frame, to this clock's time.

        Both times are in seconds. The result is never later than the present time. A simulator's clock always returns
        the present time.
        """
        return self.now()

    @abstractmethod
    def close(self) -> None:
        """Cancel all scheduled calls."""


class SteppedClock(Clock):
    """The clock of a simulator. Time passes in whole simulation steps, and only within `sleep_until`.

    Calls of `call_at` are made between two steps.

    rate_hz: the number of ticks per second.
    advance: a function that lets the simulator take a number of steps.
    step_s: the simulator's fixed time step, in seconds. If it is None, the clock chooses the step.

    Raises UsageError if a tick is not a whole number of steps.

    >>> clock = SteppedClock(20, advance=lambda steps: None)
    >>> clock.sleep_until(0.05), clock.now()
    (True, 0.05)
    """

    def __init__(self, rate_hz: float, advance: Callable[[int], None], step_s: float | None = None) -> None:
        if not (math.isfinite(rate_hz) and rate_hz > 0):
            raise UsageError(f"the rate is {rate_hz} Hz; it must be a positive number", kind="rate-not-positive")
        self.rate_hz = rate_hz
        per_tick = math.ceil(MIN_PHYSICS_RATE_HZ / rate_hz) if step_s is None else _steps_in_a_tick(rate_hz, step_s)
        self.steps_per_second = rate_hz * per_tick
        self._advance = advance
        self._count = 0
        self._calls: list[tuple[int, int, Callback]] = []
        self._order = itertools.count()

    @property
    def step(self) -> float:
        """The time step in seconds. Without a fixed step of the simulator, it is 1 / (rate · ⌈240 / rate⌉)."""
        return 1 / self.steps_per_second

    def round_to_steps(self, duration_s: float) -> float:
        """Return a duration in seconds, rounded to whole steps."""
        return round(duration_s * self.steps_per_second) / self.steps_per_second

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
    steps = 1 / (rate_hz * step_s)
    fitting_hz = 1 / (max(round(steps), 1) * step_s)
    if steps < 1 - _STEP_TOLERANCE or abs(steps - round(steps)) > _STEP_TOLERANCE * steps:
        raise UsageError(
            f"a tick of 1/{rate_hz:g} s is not a multiple of the simulator's time step of {step_s:g} s. "
            f"Take --rate {fitting_hz:g}, or set the simulator's time step to {1 / rate_hz:g} s",
            kind="rate-does-not-fit",
            rate_hz=fitting_hz,
        )
    return round(steps)


class ClockWrapper(Clock):
    """The base class of clocks that change some methods of another clock and forward the others."""

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

    def call_every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        return self._source.call_every(period, work, name)

    def time_of(self, monotonic_s: float) -> float:
        return self._source.time_of(monotonic_s)

    def close(self) -> None:
        self._source.close()


class TickClock(ClockWrapper):
    """The clock of the control loop. Its time is constant within a tick. The end of a sleep begins the next tick."""

    def __init__(self, source: Clock) -> None:
        super().__init__(source)
        self._now = source.now()
        self.tick = 0
        self.reading = 0
        """The number of ticks and renewals. A sensor is read at most once in each."""
        self.renewal_age: float | None = None
        """The age of a tick in seconds at which `renew` renews it. None while the loop runs."""

    def now(self) -> float:
        return self._now

    def tick_age(self) -> float:
        """Return the time that has passed since the beginning of the present tick, in seconds."""
        return self._source.now() - self._now

    def begin_tick(self) -> None:
        """Begin a new tick at the present time."""
        self.sleep_until(self._source.now())

    def renew(self) -> None:
        """Set the time of the tick to the present time if the loop is paused and the tick is old.

        A sensor's read calls this. The number of the tick stays, because only the loop records ticks.
        """
        if self.renewal_age is not None and self.tick_age() > self.renewal_age:
            self.begin_tick()
            self.tick -= 1

    def sleep_until(self, deadline: float) -> bool:
        is_ahead = self._source.sleep_until(deadline)
        self._now = self._source.now()
        self.tick += 1
        self.reading += 1
        return is_ahead


class AppClock(Clock):
    """The clock that an app gets. The app can only read the time, and cannot sleep or schedule calls."""

    def __init__(self, ticks: TickClock) -> None:
        self._ticks = ticks
        self.is_lockstep = ticks.is_lockstep

    def now(self) -> float:
        return self._ticks.now()

    def sleep_until(self, deadline: float) -> bool:
        raise UsageError(
            "an app cannot sleep. Return Status.RUNNING from step, which is then called again in the next tick",
            kind="app-sleeps",
        )

    def call_at(self, deadline: float, callback: Callback) -> None:
        raise UsageError(
            "an app cannot schedule a call. Compare robot.clock.now() in step with the time to wait for",
            kind="app-wants-call",
        )

    def call_every(self, period: float, work: Callable[[], object], name: str) -> PeriodicTask:
        raise UsageError(
            "an app cannot schedule periodic calls. Do the work in step, which is called once in each tick",
            kind="app-polls",
        )

    def close(self) -> None:
        """Do nothing. The control loop closes the clock."""
