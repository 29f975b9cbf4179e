"""The loop that limits the number of unfinished tasks."""

from __future__ import annotations

from concurrent.futures import Future

import pytest

from robotcore.sweep import engine
from robotcore.sweep.engine import iterate_completed


def test_an_exception_of_count_allowed_ends_the_iteration(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "POLL_S", 0.0)
    allowed = [2, 2]
    with pytest.raises(IndexError):
        list(iterate_completed(lambda _: Future(), range(9), allowed.pop))


def test_more_tasks_start_if_more_tasks_are_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine, "POLL_S", 0.0)
    started: list[Future[int]] = []

    def submit(task: int) -> Future[int]:
        started.append(Future())
        if len(started) == 3:
            started[-1].set_result(task)
        return started[-1]

    allowed = iter((1, 1, 3))
    ((task, future),) = [next(iterate_completed(submit, range(9), lambda: next(allowed)))]
    assert (task, future.result(), len(started)) == (2, 2, 3)
