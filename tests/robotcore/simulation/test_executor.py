"""Work that no signal cuts in two."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator

import pytest

from robotcore.hal.wall_clock import MonotonicClock
from robotcore.simulation.executor import Uninterrupted


@pytest.fixture
def work() -> Iterator[Uninterrupted]:
    work = Uninterrupted("work")
    yield work
    work.close()


def test_signal_interrupts_who_waits_and_what_is_asked_next_comes_after_the_work(work: Uninterrupted) -> None:
    done: list[str] = []

    def talk() -> None:
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)
        clock = MonotonicClock()
        clock.sleep_until(clock.now() + 0.05)
        done.append("talk")

    with pytest.raises(KeyboardInterrupt):
        work.do(talk)
    work.do(lambda: done.append("stop"))
    assert done == ["talk", "stop"]


def test_what_fails_fails_where_it_was_asked_for(work: Uninterrupted) -> None:
    with pytest.raises(ZeroDivisionError):
        work.do(lambda: 1 / 0)
    assert work.do(lambda: 1) == 1


def test_work_may_ask_for_more(work: Uninterrupted) -> None:
    assert work.do(lambda: work.do(lambda: 1) + 1) == 2


def test_close_ends_the_thread_and_leaves_the_work_to_who_asks(work: Uninterrupted) -> None:
    before = threading.active_count()
    work.close()
    work.close()
    assert threading.active_count() == before - 1
    assert work.do(threading.current_thread) is threading.current_thread()
