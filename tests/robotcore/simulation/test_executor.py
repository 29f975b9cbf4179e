"""Work that no signal cuts in two."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator

import pytest

from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Angle
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.simulation.executor import SerialExecutor
from robotcore.simulation.sampling import SampleCache


@pytest.fixture
def work() -> Iterator[SerialExecutor]:
    work = SerialExecutor("work")
    yield work
    work.close()


def test_signal_interrupts_who_waits_and_what_is_asked_next_comes_after_the_work(work: SerialExecutor) -> None:
    done: list[str] = []

    def talk() -> None:
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        clock = MonotonicClock()
        clock.sleep_until(clock.now() + 0.05)
        done.append("talk")

    with pytest.raises(KeyboardInterrupt):
        work.run(talk)
    work.run(lambda: done.append("stop"))
    assert done == ["talk", "stop"]


def test_what_fails_fails_where_it_was_asked_for(work: SerialExecutor) -> None:
    with pytest.raises(ZeroDivisionError):
        work.run(lambda: 1 / 0)
    assert work.run(lambda: 1) == 1


def test_work_may_ask_for_more(work: SerialExecutor) -> None:
    assert work.run(lambda: work.run(lambda: 1) + 1) == 2


def test_close_ends_the_thread_and_leaves_the_work_to_who_asks(work: SerialExecutor) -> None:
    before = threading.active_count()
    work.close()
    work.close()
    assert threading.active_count() == before - 1
    assert work.run(threading.current_thread) is threading.current_thread()


def test_a_sample_is_taken_when_it_is_read_and_once_an_instant() -> None:
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
