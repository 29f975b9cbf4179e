from __future__ import annotations

import math
import threading
from collections.abc import Iterator

import pytest

from robotcore.errors import UsageError
from robotcore.hal.clock import Clock, SteppedClock, TickClock
from robotcore.hal.wall_clock import MonotonicClock, ServerClock
from tests.texts import Raises


class FakeTime:
    """Replaces the module ``time``. Time passes only in `sleep`, which takes slightly too long, like a real sleep."""

    def __init__(self) -> None:
        self.t = 1000.0
        self.naps: list[float] = []

    def monotonic(self) -> float:
        return self.t

    def sleep(self, seconds: float) -> None:
        self.naps.append(seconds)
        self.t += seconds + 1e-9


@pytest.fixture
def fake_time(monkeypatch: pytest.MonkeyPatch) -> FakeTime:
    fake = FakeTime()
    monkeypatch.setattr("robotcore.hal.wall_clock.time", fake)
    return fake


@pytest.fixture
def monotonic() -> Iterator[MonotonicClock]:
    clock = MonotonicClock()
    yield clock
    clock.close()


@pytest.fixture
def clock() -> SteppedClock:
    return SteppedClock(20, lambda _: None)


class TestSteppedClock:
    @pytest.mark.parametrize("rate_hz", [7, 20, 30, 1000])
    def test_every_tick_takes_the_same_whole_number_of_steps(self, rate_hz: float) -> None:
        taken: list[int] = []
        clock = SteppedClock(rate_hz, taken.append)
        deadline = 0.0
        for _ in range(5000):
            deadline += 1 / rate_hz
            clock.sleep_until(deadline)
        assert set(taken) == {math.ceil(240 / rate_hz)}
        assert clock.now() == sum(taken) / (rate_hz * taken[0])

    @pytest.mark.parametrize("rate_hz, step_s, steps", [(20, 0.05, 1), (10, 0.05, 2), (20, 0.0250000004, 2)])
    def test_a_simulators_own_step_is_taken_where_it_divides_the_tick(
        self, rate_hz: float, step_s: float, steps: int
    ) -> None:
        taken: list[int] = []
        clock = SteppedClock(rate_hz, taken.append, step_s)
        clock.sleep_until(1.0)
        assert taken == [steps * rate_hz]
        assert clock.now() == 1.0

    @pytest.mark.parametrize("rate_hz, step_s, fitting", [(30, 0.05, 20), (12, 0.05, 10), (9, 0.05, 10)])
    def test_a_simulators_own_step_that_does_not_fit_is_refused_with_a_rate_that_does(
        self, rate_hz: float, step_s: float, fitting: float, raises: Raises
    ) -> None:
        with raises(UsageError, "rate-does-not-fit", rate_hz=pytest.approx(fitting)):
            SteppedClock(rate_hz, lambda _: None, step_s)

    def test_call_cuts_the_sleep_at_the_first_step_that_is_not_too_early(self) -> None:
        taken: list[int] = []
        clock = SteppedClock(20, taken.append)
        called_at: list[float] = []
        clock.call_at(0.07, lambda: called_at.append(clock.now()))
        clock.sleep_until(0.2)
        assert taken == [17, 31]
        assert called_at == [17 / 240]

    def test_call_at_a_whole_step_is_not_put_off_by_rounding(self) -> None:
        for steps in range(1, 240):
            taken: list[int] = []
            clock = SteppedClock(20, taken.append)
            clock.call_at(steps * clock.step, lambda: None)
            clock.sleep_until(1.0)
            assert taken == [steps, 240 - steps], steps

    def test_calls_come_in_the_order_of_their_times_then_of_asking(self, clock: SteppedClock) -> None:
        calls = list[str]()
        for name, deadline in (("c", 0.03), ("a", 0.01), ("b1", 0.02), ("b2", 0.02)):
            clock.call_at(deadline, lambda name=name: calls.append(name))  # type: ignore[misc]
        clock.sleep_until(0.05)
        assert calls == ["a", "b1", "b2", "c"]

    def test_a_call_that_is_overdue_is_made_first_and_turns_nothing_back(self, clock: SteppedClock) -> None:
        called_at = list[float]()
        clock.sleep_until(0.1)
        clock.call_at(0.05, lambda: called_at.append(clock.now()))
        clock.sleep_until(0.15)
        assert called_at == [0.1]

    def test_a_deadline_that_has_passed_takes_no_step(self, clock: SteppedClock) -> None:
        assert clock.sleep_until(0.1)
        assert clock.sleep_until(0.1)
        assert not clock.sleep_until(0.05)
        assert clock.now() == 0.1

    @pytest.mark.parametrize("rate_hz", [0, -20, math.nan, math.inf])
    def test_a_rate_that_is_none_is_refused(self, rate_hz: float, raises: Raises) -> None:
        with raises(UsageError, "rate-not-positive"):
            SteppedClock(rate_hz, lambda _: None)


class TestMomentsOfTheKernel:
    def test_times_are_reported_in_the_time_of_a_clock_that_runs_with_the_machine(self, fake_time: FakeTime) -> None:
        fake_time.t = 1000.0
        clock = MonotonicClock()
        fake_time.t = 1003.0
        assert clock.time_of(1002.5) == 2.5
        assert TickClock(clock).time_of(1002.5) == 2.5

    def test_times_are_never_in_the_future(self, fake_time: FakeTime) -> None:
        clock = MonotonicClock()
        fake_time.t += 3.0
        assert clock.time_of(fake_time.t + 0.001) == clock.now() == 3.0

    def test_times_are_the_present_time_with_a_simulators_clock(self) -> None:
        stepped = SteppedClock(20, lambda _: None)
        stepped.sleep_until(1.0)
        assert stepped.time_of(123_456.0) == TickClock(stepped).time_of(123_456.0) == 1.0
        assert ServerClock(iter([5.0, 7.0]).__next__).time_of(123_456.0) == 2.0


class TestMonotonicClock:
    def test_begins_at_zero_and_sleeps_to_the_deadline(self, fake_time: FakeTime) -> None:
        clock = MonotonicClock()
        assert clock.now() == 0.0
        assert clock.sleep_until(0.25)
        assert clock.now() == pytest.approx(0.25)

    def test_says_when_the_deadline_has_passed_and_does_not_sleep(self, fake_time: FakeTime) -> None:
        clock = MonotonicClock()
        fake_time.t += 1.0
        assert clock.sleep_until(1.0)
        assert not clock.sleep_until(0.5)
        assert fake_time.naps == []

    def test_an_earlier_call_overtakes_one_that_is_awaited(self, monotonic: MonotonicClock) -> None:
        called = threading.Event()
        monotonic.call_at(3600.0, _fail)
        monotonic.call_at(0.0, called.set)
        assert called.wait(10)

    def test_closing_ends_the_thread_and_forgets_the_calls(self) -> None:
        clock, before = MonotonicClock(), threading.active_count()
        clock.call_at(3600.0, _fail)
        assert threading.active_count() == before + 1
        clock.close()
        clock.close()
        assert threading.active_count() == before

    def test_may_be_closed_by_one_of_its_calls(self) -> None:
        clock, closed = MonotonicClock(), threading.Event()

        def close() -> None:
            clock.close()
            closed.set()

        clock.call_at(0.0, close)
        assert closed.wait(10)
        clock.close()

    def test_what_a_call_raised_is_raised_by_the_next_sleep_once(self, monotonic: MonotonicClock) -> None:
        _call_and_fail(monotonic)
        with pytest.raises(ZeroDivisionError):
            monotonic.sleep_until(3600.0)
        assert monotonic.sleep_until(monotonic.now() + 0.001)
        called = threading.Event()
        monotonic.call_at(0.0, called.set)
        assert called.wait(10)

    def test_what_a_call_raised_after_the_last_sleep_is_raised_by_closing(self) -> None:
        clock, before = MonotonicClock(), threading.active_count()
        _call_and_fail(clock)
        with pytest.raises(ZeroDivisionError):
            clock.close()
        assert threading.active_count() == before
        clock.close()


class TestServerClock:
    def test_follows_the_servers_time_however_fast_it_runs(self, fake_time: FakeTime) -> None:
        clock = ServerClock(lambda: (fake_time.t - 1000.0) / 2)
        assert clock.sleep_until(0.1)
        assert fake_time.t == pytest.approx(1000.2, abs=0.006)
        assert max(fake_time.naps) <= 0.005

    def test_a_server_that_fails_while_a_call_is_awaited_is_reported_to_the_sleeper(self) -> None:
        asked_by_thread = threading.Event()

        def source() -> float:
            if threading.current_thread() is threading.main_thread():
                return 0.0
            asked_by_thread.set()
            raise ConnectionError("the server has gone")

        clock = ServerClock(source)
        clock.call_at(1.0, _fail)
        assert asked_by_thread.wait(10)
        with pytest.raises(ConnectionError):
            clock.sleep_until(1.0)
        clock.close()


def test_calls_and_closing_reach_the_wrapped_clock() -> None:
    clock, calls = TickClock(SteppedClock(20, lambda _: None)), list[str]()
    clock.call_at(0.01, lambda: calls.append("made"))
    clock.call_every(0.05, lambda: calls.append("repeated"), "echo")
    clock.sleep_until(0.05)
    clock.call_at(0.06, _fail)
    clock.close()
    clock.sleep_until(0.1)
    assert calls == ["made", "repeated"]


class TestTickClock:
    def test_stands_still_within_a_tick(self, fake_time: FakeTime) -> None:
        clock = TickClock(MonotonicClock())
        fake_time.t += 0.3
        assert clock.now() == 0.0

    def test_a_sleep_begins_the_next_tick_with_the_time_that_it_then_is(self, fake_time: FakeTime) -> None:
        source = MonotonicClock()
        clock = TickClock(source)
        fake_time.t += 0.3
        assert not clock.sleep_until(0.05)
        assert clock.tick == 1
        assert clock.now() == pytest.approx(0.3)
        assert clock.sleep_until(0.4)
        assert clock.tick == 2
        assert clock.now() == pytest.approx(0.4)


def _call_and_fail(clock: Clock) -> None:
    """Make a scheduled call fail, and wait until the clock has stored the failure."""
    reached = threading.Event()
    clock.call_at(0.0, _fail)
    clock.call_at(0.0, reached.set)
    assert reached.wait(10)


def _fail() -> None:
    raise ZeroDivisionError


def test_a_call_of_a_real_clock_that_runs_out_of_memory_is_made_again() -> None:
    clock, made = MonotonicClock(), threading.Event()
    tries: list[int] = []

    def call() -> None:
        tries.append(1)
        if len(tries) < 3:
            raise MemoryError
        made.set()

    clock.call_at(0.0, call)
    assert made.wait(10)
    clock.close()


def test_a_real_clock_whose_waiting_runs_out_of_memory_calls_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, made = MonotonicClock(), threading.Event()
    refusals, really_wait = iter([MemoryError(), RuntimeError("can't allocate lock")]), clock._wake.wait

    def wait(timeout: float) -> None:
        for refusal in refusals:
            raise refusal
        really_wait(timeout)

    monkeypatch.setattr(clock._wake, "wait", wait)
    clock.call_at(0.05, made.set)
    assert made.wait(10)
    clock.close()
