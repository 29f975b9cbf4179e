"""The loop that limits the number of tasks at a time."""

from __future__ import annotations

from concurrent.futures import Future

import pytest

from robotcore.sweep import engine
from robotcore.sweep.engine import iterate_completed


def test_an_exception_of_width_ends_the_wait_for_a_task(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "POLL_S", 0.0)
    widths = [2, 2]
    with pytest.raises(IndexError):
        list(iterate_completed(lambda _: Future(), range(9), widths.pop))


def test_more_tasks_start_if_the_width_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "POLL_S", 0.0)
    started: list[Future[int]] = []

    def submit(task: int) -> Future[int]:
        started.append(Future())
        if len(started) == 3:
            started[-1].set_result(task)
        return started[-1]

    widths = iter((1, 1, 3))
    ((task, future),) = [next(iterate_completed(submit, range(9), lambda: next(widths)))]
    assert (task, future.result(), len(started)) == (2, 2, 3)
