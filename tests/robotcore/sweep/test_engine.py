"""A bounded number of tasks under way."""

from __future__ import annotations

from concurrent.futures import Future

import pytest

from robotcore.sweep import engine as window
from robotcore.sweep.engine import iterate_completed


def test_what_the_width_raises_ends_a_wait_for_what_never_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(window, "POLL_S", 0.0)
    widths = iter((2, 2))
    with pytest.raises(RuntimeError, match="StopIteration"):
        list(iterate_completed(lambda _: Future(), range(9), lambda: next(widths)))


def test_a_window_that_widens_meanwhile_is_filled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(window, "POLL_S", 0.0)
    started: list[Future[int]] = []

    def submit(task: int) -> Future[int]:
        started.append(Future())
        if len(started) == 3:
            started[-1].set_result(task)
        return started[-1]

    widths = iter((1, 1, 3))
    ((task, future),) = [next(iterate_completed(submit, range(9), lambda: next(widths)))]
    assert (task, future.result(), len(started)) == (2, 2, 3)
