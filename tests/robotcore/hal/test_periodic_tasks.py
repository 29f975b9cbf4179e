"""Work beside the app: pumped by simulated time, done by a thread in real time."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import suppress

import pytest

from robotcore.errors import BackendError, UsageError
from robotcore.hal.clock import AppClock, SteppedClock, TickClock
from robotcore.hal.wall_clock import MonotonicClock, PacedClock, ServerClock

AGES_S = 10.0
"""A thread that has not come by then never will."""


@pytest.fixture
def stepped() -> SteppedClock:
    return SteppedClock(20, lambda _steps: None)


@pytest.fixture
def monotonic() -> Iterator[MonotonicClock]:
    clock = MonotonicClock()
    yield clock
    clock.close()


class TestUnderSimulatedTime:
    def test_work_is_done_whenever_it_is_due_by_whoever_lets_time_pass(self, stepped: SteppedClock) -> None:
        done: list[float] = []
        threads: set[threading.Thread] = set()

        def work() -> None:
            done.append(stepped.now())
            threads.add(threading.current_thread())

        stepped.every(0.025, work, "echo")
        stepped.sleep_until(0.1)
        assert done == pytest.approx([0.025, 0.05, 0.075, 0.1])
        assert threads == {threading.current_thread()}

    def test_periods_that_no_step_fits_do_not_drift(self, stepped: SteppedClock) -> None:
        done: list[float] = []
        stepped.every(0.0601, lambda: done.append(stepped.now()), "echo")
        stepped.sleep_until(60.2)
        assert len(done) == 1001
        assert all(0 <= at - n * 0.0601 <= stepped.step for n, at in enumerate(done, start=1))

    def test_stopped_work_is_not_begun_again_even_from_within(self, stepped: SteppedClock) -> None:
        done: list[float] = []

        def work() -> None:
            done.append(stepped.now())
            if len(done) == 2:
                polling.stop()

        polling = stepped.every(0.025, work, "echo")
        stepped.sleep_until(1.0)
        polling.stop()
        assert done == pytest.approx([0.025, 0.05])

    def test_what_work_raises_is_raised_to_whoever_lets_time_pass(self, stepped: SteppedClock) -> None:
        def work() -> None:
            raise ValueError("a bug in a driver")

        stepped.every(0.025, work, "echo")
        with pytest.raises(ValueError):  # noqa: PT011  it has no kind
            stepped.sleep_until(1.0)

    def test_views_of_a_clock_hand_the_work_on(self, stepped: SteppedClock) -> None:
        done: list[str] = []
        TickClock(stepped).every(0.025, lambda: done.append("tick"), "echo")
        PacedClock(stepped).every(0.025, lambda: done.append("paced"), "echo")
        stepped.sleep_until(0.025)
        assert done == ["tick", "paced"]


class TestInRealTime:
    def test_work_is_done_again_and_again_by_a_thread_of_that_name(self, monotonic: MonotonicClock) -> None:
        threads: list[str] = []
        third = threading.Event()

        def work() -> None:
            threads.append(threading.current_thread().name)
            if len(threads) == 3:
                third.set()

        polling = monotonic.every(0.001, work, "echo")
        assert third.wait(AGES_S)
        polling.stop()
        assert set(threads) == {"echo"}

    def test_work_that_waits_for_hardware_holds_up_no_other_and_no_call(self, monotonic: MonotonicClock) -> None:
        release, other, called = threading.Event(), threading.Event(), threading.Event()
        hung = monotonic.every(0.001, lambda: release.wait(AGES_S), "hung")
        sound = monotonic.every(0.001, other.set, "sound")
        monotonic.call_at(monotonic.now() + 0.001, called.set)
        assert other.wait(AGES_S)
        assert called.wait(AGES_S)
        release.set()
        hung.stop()
        sound.stop()

    def test_stopping_waits_for_what_is_under_way_and_begins_nothing_more(self, monotonic: MonotonicClock) -> None:
        begun, ended = threading.Event(), list[float]()

        def work() -> None:
            begun.set()
            monotonic.sleep_until(monotonic.now() + 0.05)
            ended.append(monotonic.now())

        polling = monotonic.every(0.001, work, "slow")
        assert begun.wait(AGES_S)
        polling.stop()
        seen = list(ended)
        monotonic.sleep_until(monotonic.now() + 0.1)
        assert seen
        assert ended == seen

    def test_stopping_from_within_does_not_wait_for_itself(self, monotonic: MonotonicClock) -> None:
        stopped = threading.Event()

        def work() -> None:
            polling.stop()
            stopped.set()

        polling = monotonic.every(0.02, work, "echo")
        assert stopped.wait(AGES_S)

    def test_what_work_raises_ends_the_sleep_of_whoever_ticks_and_not_the_work(self) -> None:
        clock, calls, third = MonotonicClock(), list[int](), threading.Event()

        def work() -> None:
            calls.append(len(calls))
            if len(calls) == 3:
                third.set()
            raise ValueError("a bug in a driver")

        polling = clock.every(0.001, work, "echo")
        assert third.wait(AGES_S)
        with pytest.raises(ValueError):  # noqa: PT011  it has no kind
            clock.sleep_until(clock.now() + AGES_S)
        polling.stop()
        with suppress(ValueError):
            clock.close()

    def test_a_server_s_time_is_followed_by_a_thread_too(self) -> None:
        done = threading.Event()
        clock, wall = ServerClock(source := MonotonicClock().now), MonotonicClock()
        polling = clock.every(0.001, done.set, "echo")
        assert done.wait(AGES_S)
        polling.stop()
        clock.close()
        wall.close()
        assert source() > 0


def test_an_app_polls_nothing(stepped: SteppedClock) -> None:
    with pytest.raises(UsageError):
        AppClock(TickClock(stepped)).every(0.1, lambda: None, "echo")


def test_work_by_a_servers_time_ends_quietly_with_the_server_and_the_sleeper_is_reported() -> None:
    is_gone = threading.Event()
    wall = MonotonicClock()

    def time() -> float:
        if is_gone.is_set():
            raise BackendError("the server is gone")
        return wall.now()

    clock = ServerClock(time)
    worked = threading.Event()
    polling = clock.every(0.001, worked.set, "echo")
    assert worked.wait(AGES_S)
    is_gone.set()
    polling.stop()
    with pytest.raises(BackendError):
        clock.sleep_until(1.0)
