"""Limits of time grow with the machine's slowness, and never shrink."""

from __future__ import annotations

import os

import pytest

from tests.system import speed


@pytest.fixture(autouse=True)
def _is_unmeasured(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(speed.VARIABLE, "1")  # restored after the test
    monkeypatch.delenv(speed.VARIABLE)


def work_takes(seconds: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speed, "measure_work", lambda: seconds)


def test_a_machine_that_is_three_times_slower_has_three_times_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    work_takes(3 * speed.REFERENCE_S, monkeypatch)
    assert speed.scaled(20.0) == pytest.approx(60.0)


def test_a_faster_machine_keeps_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    work_takes(0.1 * speed.REFERENCE_S, monkeypatch)
    assert speed.scaled(20.0) == 20.0


def test_the_speed_is_measured_once_and_passed_to_child_processes(monkeypatch: pytest.MonkeyPatch) -> None:
    work_takes(2 * speed.REFERENCE_S, monkeypatch)
    assert speed.slowness() == 2.0
    work_takes(9 * speed.REFERENCE_S, monkeypatch)
    assert (speed.slowness(), os.environ[speed.VARIABLE]) == (2.0, "2.00")


@pytest.mark.parametrize("given, slowness", [("4", 4.0), ("0.1", 1.0)])
def test_a_user_may_give_more_time_and_not_less(given: str, slowness: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(speed.VARIABLE, given)
    assert speed.slowness() == slowness


def test_the_work_takes_time() -> None:
    assert speed.measure_work() > 0.01
