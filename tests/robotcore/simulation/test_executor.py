"""Tests of `SerialExecutor` and `SampleCache`."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator

import pytest

from robotcore.hal.clock import SteppedClock
from robotcore.hal.sampling import SampleCache
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.encoder import Angle
from robotcore.simulation.executor import SerialExecutor


@pytest.fixture
def executor() -> Iterator[SerialExecutor]:
    executor = SerialExecutor("work")
    yield executor
    executor.close()


@pytest.fixture
def _has_sigint() -> Iterator[None]:
    # A shell starts a job in the background with SIGINT ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("_has_sigint")
def test_signal_interrupts_the_caller_and_the_next_task_waits_for_the_first(executor: SerialExecutor) -> None:
    done: list[str] = []

    def task() -> None:
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        clock = MonotonicClock()
        clock.sleep_until(clock.now() + 0.05)
        done.append("task")

    with pytest.raises(KeyboardInterrupt):
        executor.run(task)
    executor.run(lambda: done.append("stop"))
    assert done == ["task", "stop"]


def test_exception_of_a_task_is_raised_in_the_caller(executor: SerialExecutor) -> None:
    with pytest.raises(ZeroDivisionError):
        executor.run(lambda: 1 / 0)
    assert executor.run(lambda: 1) == 1


def test_task_may_run_another_task(executor: SerialExecutor) -> None:
    assert executor.run(lambda: executor.run(lambda: 1) + 1) == 2


def test_closed_executor_runs_tasks_in_the_callers_thread(executor: SerialExecutor) -> None:
    before = threading.active_count()
    executor.close()
    executor.close()
    assert threading.active_count() == before - 1
    assert executor.run(threading.current_thread) is threading.current_thread()


def test_sample_is_taken_by_the_first_read_of_an_instant() -> None:
    clock = SteppedClock(20.0, lambda steps: None)
    taken: list[Angle] = []

    def take(time: float, sequence: int) -> Angle:
        taken.append(Angle(0.0, time, sequence))
        return taken[-1]

    read = SampleCache(clock, take)
    clock.sleep_until(1.0)
    assert not taken
    assert read() is read()
    clock.sleep_until(1.5)
    clock.sleep_until(2.0)
    assert read() is taken[1]
    assert [(sample.time, sample.sequence) for sample in taken] == [(1.0, 0), (2.0, 1)]
