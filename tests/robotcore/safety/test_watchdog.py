from __future__ import annotations

import sys
import threading
from types import FrameType
from typing import Any

import pytest

from robotcore.errors import DeviceError, RobotcoreError, WatchdogError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.thread_reserve import Reserve
from robotcore.safety.watchdog import FIRST_TICK_S, MAX_PASSED_S, NOTICE_S, ActivityMonitor, TimeLimit, Watchdog

STEP = TimeLimit(3.0, lambda seconds, _: WatchdogError(f"the app, {seconds:.1f} s"), 1.0, is_step=True)
EYE = TimeLimit(1.0, lambda seconds, _: DeviceError("eye", f"{seconds:.1f} s"), 0.3)


class Bench:
    """A watchdog whose checks the test calls, after the first tick."""

    def __init__(self, scale: float = 1.0) -> None:
        self.monitor = ActivityMonitor()
        self.monitor.ticks = 2
        self.timeouts: list[RobotcoreError] = []
        self.ends: list[RobotcoreError] = []
        self.notes: list[str] = []
        self.watchdog = Watchdog(
            self.monitor, self.timeouts.append, self.ends.append, Reserve(MonotonicClock()), scale, self.notes.append
        )

    def pass_time(self, seconds: float) -> None:
        for _ in range(round(seconds * 20)):
            self.watchdog._check(0.05)

    def pass_time_in_the_eye(self, seconds: float) -> None:
        self.monitor.call_driver(EYE, self.pass_time, seconds)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_app_that_does_not_return_exceeds_its_limit(bench: Bench) -> None:
    bench.monitor.begin(STEP)
    bench.pass_time(3.0)
    assert not bench.timeouts
    bench.pass_time(0.2)
    (error,) = bench.timeouts
    assert isinstance(error, WatchdogError)


def test_app_that_returns_each_time_exceeds_no_limit(bench: Bench) -> None:
    for _ in range(10):
        bench.monitor.begin(STEP)
        bench.pass_time(2.5)
    assert not bench.timeouts


def test_driver_that_hangs_is_named_instead_of_the_app(bench: Bench) -> None:
    bench.monitor.begin(STEP)
    bench.pass_time_in_the_eye(1.2)
    (error,) = bench.timeouts
    assert isinstance(error, DeviceError)
    assert error.device == "eye"


def test_many_driver_calls_that_return_exceed_no_limit(bench: Bench) -> None:
    bench.monitor.begin(STEP)
    for _ in range(6):
        bench.pass_time_in_the_eye(0.9)
    assert not bench.timeouts


def test_app_that_reads_for_ever_exceeds_its_limit(bench: Bench) -> None:
    bench.monitor.begin(STEP)
    for _ in range(40):
        bench.pass_time_in_the_eye(0.05)
        bench.pass_time(0.1)
    assert isinstance(bench.timeouts[0], WatchdogError)


def test_call_of_another_thread_exceeds_no_limit(bench: Bench) -> None:
    bench.monitor.begin(STEP)
    thread = threading.Thread(target=bench.pass_time_in_the_eye, args=(2.0,))
    thread.start()
    thread.join()
    assert not bench.timeouts


def test_first_tick_has_a_longer_limit(bench: Bench) -> None:
    bench.monitor.ticks = 1
    bench.monitor.begin(STEP)
    bench.pass_time(FIRST_TICK_S)
    assert not bench.timeouts
    bench.pass_time(0.2)
    assert bench.timeouts


def test_long_first_tick_is_reported_once(bench: Bench) -> None:
    bench.monitor.ticks = 1
    bench.monitor.begin(STEP)
    bench.pass_time(NOTICE_S)
    assert not bench.notes
    bench.pass_time(NOTICE_S)
    assert [note.partition(",")[0] for note in bench.notes] == ["the app"]


def test_long_activity_after_the_step_of_the_first_tick_is_not_reported(bench: Bench) -> None:
    bench.monitor.ticks = 1
    bench.monitor.begin(STEP._replace(is_step=False))
    bench.pass_time(2 * NOTICE_S)
    assert not bench.notes


def test_scale_is_a_factor_on_every_limit() -> None:
    bench = Bench(scale=10.0)
    bench.monitor.begin(STEP)
    bench.pass_time_in_the_eye(9.0)
    bench.pass_time(29.0)
    assert not bench.timeouts


def test_thread_that_does_not_continue_within_the_grace_is_ended_once(bench: Bench) -> None:
    bench.monitor.begin(STEP)
    bench.pass_time(3.2)
    bench.pass_time(0.8)
    assert not bench.ends
    bench.pass_time(5.0)
    assert bench.ends == bench.timeouts
    assert len(bench.ends) == 1


def test_thread_that_continues_is_not_ended(bench: Bench) -> None:
    bench.monitor.begin(STEP)
    bench.pass_time(3.2)
    bench.monitor.begin(None)
    bench.pass_time(5.0)
    assert not bench.ends


def test_thread_that_hangs_twice_exceeds_two_limits(bench: Bench) -> None:
    bench.monitor.begin(STEP)
    bench.pass_time(3.2)
    bench.monitor.begin(STEP)
    bench.pass_time(3.2)
    assert len(bench.timeouts) == 2


def test_thread_under_a_debugger_exceeds_no_limit(bench: Bench) -> None:
    def trace(frame: FrameType, event: str, argument: object) -> Any:
        return trace

    def held() -> None:
        bench.monitor.begin(STEP)
        bench.pass_time(4.0)

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        held()
    finally:
        sys.settrace(before)
    assert not bench.timeouts


def test_watchdog_checks_in_its_own_thread_until_it_is_closed() -> None:
    timeout = threading.Event()
    monitor = ActivityMonitor()
    monitor.ticks = 2
    monitor.begin(STEP._replace(limit_s=0.1))
    watchdog = Watchdog(monitor, lambda _: timeout.set(), lambda _: None, Reserve(MonotonicClock()))
    watchdog.start()
    try:
        assert timeout.wait(10)
    finally:
        watchdog.close()
        watchdog.close()
    assert watchdog._thread
    assert not watchdog._thread.is_alive()


def test_end_is_called_even_if_on_timeout_raises() -> None:
    ended = threading.Event()
    monitor = ActivityMonitor()
    monitor.ticks = 2
    monitor.begin(STEP._replace(limit_s=0.1, grace_s=0.1))

    def fail(error: RobotcoreError) -> None:
        raise MemoryError

    watchdog = Watchdog(monitor, fail, lambda _: ended.set(), Reserve(MonotonicClock()))
    watchdog.start()
    try:
        assert ended.wait(10)
    finally:
        watchdog.close()


def test_time_in_which_the_process_was_suspended_does_not_count(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    passed: list[float] = []
    checked = threading.Event()

    def check(seconds: float) -> None:
        passed.append(seconds)
        checked.set()

    monkeypatch.setattr("robotcore.safety.watchdog.MonotonicClock.now", lambda _: 3600.0 * len(passed) + 3600.0)
    monkeypatch.setattr(bench.watchdog, "_check", check)
    bench.watchdog.start()
    assert checked.wait(10)
    bench.watchdog.close()
    assert passed[0] == MAX_PASSED_S
