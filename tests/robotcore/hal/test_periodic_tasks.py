"""Periodic calls of `Clock.call_every`: in the caller's thread in simulated time, in their own thread otherwise."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest

from robotcore.errors import BackendError, UsageError
from robotcore.hal.clock import AppClock, Clock, SteppedClock, TickClock
from robotcore.hal.wall_clock import MonotonicClock, ServerClock

THREAD_TIMEOUT_S = 10.0
"""The longest time, in seconds, that a test waits for a thread."""


@pytest.fixture
def stepped() -> SteppedClock:
    return SteppedClock(20, lambda _steps: None)


@pytest.fixture
def monotonic() -> Iterator[MonotonicClock]:
    clock = MonotonicClock()
    yield clock
    clock.close()


class TestSimulatedTime:
    def test_period_that_is_no_multiple_of_a_step_does_not_drift(self, stepped: SteppedClock) -> None:
        times: list[float] = []
        stepped.call_every(0.0601, lambda: times.append(stepped.now()), "echo")
        stepped.sleep_until(60.2)
        assert len(times) == 1001
        assert all(0 <= at - n * 0.0601 <= stepped.step for n, at in enumerate(times, start=1))

    def test_task_that_stops_itself_is_not_called_again(self, stepped: SteppedClock) -> None:
        times: list[float] = []

        def task() -> None:
            times.append(stepped.now())
            if len(times) == 2:
                polling.stop()

        polling = stepped.call_every(0.025, task, "echo")
        stepped.sleep_until(1.0)
        polling.stop()
        assert times == pytest.approx([0.025, 0.05])

    def test_exception_of_a_task_is_raised_by_the_sleep(self, stepped: SteppedClock) -> None:
        def task() -> None:
            raise ValueError("a bug in a driver")

        stepped.call_every(0.025, task, "echo")
        with pytest.raises(ValueError):  # noqa: PT011  it has no kind
            stepped.sleep_until(1.0)


class TestRealTime:
    def test_a_thread_with_the_given_name_repeats_the_task(self, monotonic: MonotonicClock) -> None:
        threads: list[str] = []
        third = threading.Event()

        def task() -> None:
            threads.append(threading.current_thread().name)
            if len(threads) == 3:
                third.set()

        polling = monotonic.call_every(0.001, task, "echo")
        assert third.wait(THREAD_TIMEOUT_S)
        polling.stop()
        assert set(threads) == {"echo"}

    def test_blocked_task_delays_no_other_task_and_no_scheduled_call(self, monotonic: MonotonicClock) -> None:
        release, other, called = threading.Event(), threading.Event(), threading.Event()
        hung = monotonic.call_every(0.001, lambda: release.wait(THREAD_TIMEOUT_S), "hung")
        sound = monotonic.call_every(0.001, other.set, "sound")
        monotonic.call_at(monotonic.now() + 0.001, called.set)
        assert other.wait(THREAD_TIMEOUT_S)
        assert called.wait(THREAD_TIMEOUT_S)
        release.set()
        hung.stop()
        sound.stop()

    def test_stop_waits_for_the_running_call_and_starts_no_other(self, monotonic: MonotonicClock) -> None:
        begun, ended = threading.Event(), list[float]()

        def task() -> None:
            begun.set()
            monotonic.sleep_until(monotonic.now() + 0.05)
            ended.append(monotonic.now())

        polling = monotonic.call_every(0.001, task, "slow")
        assert begun.wait(THREAD_TIMEOUT_S)
        polling.stop()
        seen = list(ended)
        monotonic.sleep_until(monotonic.now() + 0.1)
        assert seen
        assert ended == seen

    def test_task_that_stops_itself_does_not_deadlock(self, monotonic: MonotonicClock) -> None:
        stopped = threading.Event()

        def task() -> None:
            polling.stop()
            stopped.set()

        polling = monotonic.call_every(0.02, task, "echo")
        assert stopped.wait(THREAD_TIMEOUT_S)

    def test_exception_of_a_task_ends_the_sleep_but_not_the_task(self) -> None:
        clock, calls, third = MonotonicClock(), list[int](), threading.Event()

        def task() -> None:
            calls.append(len(calls))
            if len(calls) == 3:
                third.set()
            raise ValueError("a bug in a driver")

        polling = clock.call_every(0.001, task, "echo")
        assert third.wait(THREAD_TIMEOUT_S)
        with pytest.raises(ValueError):  # noqa: PT011  it has no kind
            clock.sleep_until(clock.now() + THREAD_TIMEOUT_S)
        polling.stop()
        with suppress(ValueError):
            clock.close()


@pytest.mark.parametrize(
    "kind, use",
    [
        ("app-sleeps", lambda clock: clock.sleep_until(1.0)),
        ("app-wants-call", lambda clock: clock.call_at(1.0, print)),
        ("app-polls", lambda clock: clock.call_every(0.1, print, "echo")),
    ],
)
def test_an_app_can_only_read_its_clock(stepped: SteppedClock, kind: str, use: Callable[[Clock], object]) -> None:
    clock = AppClock(TickClock(stepped))
    with pytest.raises(UsageError) as caught:
        use(clock)
    assert caught.value.kind == kind
    clock.close()
    assert clock.now() == 0.0


def test_lost_server_ends_the_task_and_raises_in_the_sleep() -> None:
    is_gone = threading.Event()
    wall = MonotonicClock()

    def time() -> float:
        if is_gone.is_set():
            raise BackendError("the server is gone")
        return wall.now()

    clock = ServerClock(time)
    worked = threading.Event()
    polling = clock.call_every(0.001, worked.set, "echo")
    assert worked.wait(THREAD_TIMEOUT_S)
    is_gone.set()
    polling.stop()
    with pytest.raises(BackendError):
        clock.sleep_until(1.0)
