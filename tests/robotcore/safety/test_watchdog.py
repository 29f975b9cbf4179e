from __future__ import annotations

import sys
import threading
from pathlib import Path
from types import FrameType
from typing import Any
from unittest.mock import Mock

import pytest

from robotcore.errors import DeviceError, RobotcoreError, WatchdogError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety import ActivityMonitor, TimeLimit, Watchdog
from robotcore.safety.reserve import Reserve
from robotcore.safety.watchdog import FIRST_TICK_S, RunnableTime, is_debugged

SECOND_NS = 1_000_000_000


@pytest.fixture
def time(tmp_path: Path) -> RunnableTime:
    """The time of a thread that is looked at every second, by a clock that a test sets."""
    fair = RunnableTime(0, 1.0)
    fair._file = tmp_path / "schedstat"
    fair._file.write_text("0 0 1")
    fair._wall = Mock()
    return fair


def at(fair: RunnableTime, seconds: float, waited: float = 0.0) -> float:
    fair._wall.now.return_value = seconds  # type: ignore[attr-defined]
    fair._file.write_text(f"5 {round(waited * SECOND_NS)} 9")
    return fair.passed()


def test_counts_the_seconds_since_it_was_last_asked(time: RunnableTime) -> None:
    assert at(time, 1.0) == 1.0
    assert at(time, 1.5) == 0.5


def test_does_not_count_the_wait_for_a_processor(time: RunnableTime) -> None:
    assert at(time, 1.0, waited=0.75) == pytest.approx(0.25)
    assert at(time, 2.0, waited=0.75) == 1.0


def test_counts_a_wait_that_is_reported_late_for_as_long_as_it_was(time: RunnableTime) -> None:
    assert at(time, 1.0, waited=1.5) == 0.0
    assert at(time, 2.0, waited=1.5) == pytest.approx(0.5)


def test_does_not_count_for_how_long_whoever_looks_was_held_up(time: RunnableTime) -> None:
    assert at(time, 100.0) == 2.0


def test_counts_all_where_the_system_does_not_tell(time: RunnableTime, tmp_path: Path) -> None:
    time._file = tmp_path / "missing" / "schedstat"
    time._wall.now.return_value = 1.0  # type: ignore[attr-defined]
    assert time.passed() == 1.0


STEP = TimeLimit(3.0, lambda seconds, _: WatchdogError(f"the app, {seconds:.1f} s"), 1.0)
EYE = TimeLimit(1.0, lambda seconds, _: DeviceError("eye", f"{seconds:.1f} s"), 0.3)


class Bench:
    """A watchdog that looks when it is told to, past the first tick."""

    def __init__(self, patience: float = 1.0) -> None:
        self.where = ActivityMonitor()
        self.where.ticks = 2
        self.bites: list[RobotcoreError] = []
        self.ends: list[RobotcoreError] = []
        self.watchdog = Watchdog(self.where, self.bites.append, self.ends.append, Reserve(MonotonicClock()), patience)

    def pass_time(self, seconds: float) -> None:
        for _ in range(round(seconds * 20)):
            self.watchdog._look(0.05)

    def pass_time_in_the_eye(self, seconds: float) -> None:
        self.where.call_driver_with(EYE, self.pass_time, seconds)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_bites_where_the_app_does_not_come_back(bench: Bench) -> None:
    bench.where.begin(STEP)
    bench.pass_time(3.0)
    assert not bench.bites
    bench.pass_time(0.2)
    (error,) = bench.bites
    assert isinstance(error, WatchdogError)


def test_an_app_that_comes_back_each_time_is_left_alone(bench: Bench) -> None:
    for _ in range(10):
        bench.where.begin(STEP)
        bench.pass_time(2.5)
    assert not bench.bites


def test_names_the_device_in_whose_driver_the_program_is_not_the_app_that_asked(bench: Bench) -> None:
    bench.where.begin(STEP)
    bench.pass_time_in_the_eye(1.2)
    (error,) = bench.bites
    assert isinstance(error, DeviceError)
    assert error.device == "eye"


def test_many_calls_that_each_come_back_are_no_hang(bench: Bench) -> None:
    bench.where.begin(STEP)
    for _ in range(6):
        bench.pass_time_in_the_eye(0.9)
    assert not bench.bites


def test_an_app_that_reads_on_and_on_is_one(bench: Bench) -> None:
    bench.where.begin(STEP)
    for _ in range(40):
        bench.pass_time_in_the_eye(0.05)
        bench.pass_time(0.1)
    assert isinstance(bench.bites[0], WatchdogError)


def test_another_threads_call_is_not_the_loops(bench: Bench) -> None:
    bench.where.begin(STEP)
    thread = threading.Thread(target=bench.pass_time_in_the_eye, args=(2.0,))
    thread.start()
    thread.join()
    assert not bench.bites


def test_the_first_tick_may_load_what_it_needs(bench: Bench) -> None:
    bench.where.ticks = 1
    bench.where.begin(STEP)
    bench.pass_time(FIRST_TICK_S)
    assert not bench.bites
    bench.pass_time(0.2)
    assert bench.bites


def test_patience_makes_every_limit_longer() -> None:
    bench = Bench(patience=10.0)
    bench.where.begin(STEP)
    bench.pass_time_in_the_eye(9.0)
    bench.pass_time(29.0)
    assert not bench.bites


def test_ends_what_does_not_come_back_within_its_grace_and_bites_once(bench: Bench) -> None:
    bench.where.begin(STEP)
    bench.pass_time(3.2)
    bench.pass_time(0.8)
    assert not bench.ends
    bench.pass_time(5.0)
    assert bench.ends == bench.bites
    assert len(bench.ends) == 1


def test_ends_nothing_that_comes_back(bench: Bench) -> None:
    bench.where.begin(STEP)
    bench.pass_time(3.2)
    bench.where.begin(None)
    bench.pass_time(5.0)
    assert not bench.ends


def test_bites_again_what_came_back_and_hangs_elsewhere(bench: Bench) -> None:
    bench.where.begin(STEP)
    bench.pass_time(3.2)
    bench.where.begin(STEP)
    bench.pass_time(3.2)
    assert len(bench.bites) == 2


def test_a_debugger_holds_nothing_up_for_too_long(bench: Bench) -> None:
    def trace(frame: FrameType, event: str, argument: object) -> Any:
        return trace

    def held() -> None:
        bench.where.begin(STEP)
        bench.pass_time(4.0)

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        held()
    finally:
        sys.settrace(before)
    assert not bench.bites


def test_a_frame_that_nobody_follows_is_not_debugged() -> None:
    assert not is_debugged(None)


def test_looks_from_a_thread_of_its_own_until_it_is_closed() -> None:
    bitten = threading.Event()
    where = ActivityMonitor()
    where.ticks = 2
    where.begin(STEP._replace(limit_s=0.1))
    watchdog = Watchdog(where, lambda _: bitten.set(), lambda _: None, Reserve(MonotonicClock()))
    watchdog.start()
    try:
        assert bitten.wait(10)
    finally:
        watchdog.close()
        watchdog.close()
    assert watchdog._thread
    assert not watchdog._thread.is_alive()


def test_a_bite_that_raises_is_followed_by_the_end() -> None:
    ended = threading.Event()
    where = ActivityMonitor()
    where.ticks = 2
    where.begin(STEP._replace(limit_s=0.1, grace_s=0.1))

    def fail(error: RobotcoreError) -> None:
        raise MemoryError

    watchdog = Watchdog(where, fail, lambda _: ended.set(), Reserve(MonotonicClock()))
    watchdog.start()
    try:
        assert ended.wait(10)
    finally:
        watchdog.close()
