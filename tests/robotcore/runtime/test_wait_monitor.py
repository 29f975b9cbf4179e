"""The monitor of steps that wait."""

from __future__ import annotations

import time

import pytest

from robotcore.cli.command_classes import write_result
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.result import WrittenNote
from robotcore.runtime.session import RunRequest, run
from robotcore.runtime.wait_monitor import WaitMonitor
from tests.robotcore.fakes import FunctionApp
from tests.texts import CheckText


@pytest.mark.parametrize(
    "waits_s, simulated_s, notes", [((0.4, 0.4, 0.4), 0.05, 1), ((0.4,), 0.0, 0), ((1.2,), 1.0, 0)]
)
def test_steps_that_wait_longer_than_the_simulated_time_cause_one_note(
    waits_s: tuple[float, ...],
    simulated_s: float,
    notes: int,
    monkeypatch: pytest.MonkeyPatch,
    check_text: CheckText,
) -> None:
    clock, reported = [0.0], list[str]()
    monkeypatch.setattr("robotcore.runtime.wait_monitor.read_idle_time", lambda: clock[0])
    monkeypatch.setattr("robotcore.runtime.wait_monitor.read_queue_time", lambda: 0.0)
    monitor = WaitMonitor(reported.append)
    for wait_s in (*waits_s, 0.0):
        monitor.begin()
        clock[0] += wait_s
        monitor.end(simulated_s)
    assert len(reported) == notes
    check_text("".join(reported))


def test_wait_for_a_busy_processor_is_no_wait_of_the_app(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, reported = [0.0], list[str]()
    monkeypatch.setattr("robotcore.runtime.wait_monitor.read_idle_time", lambda: clock[0])
    monkeypatch.setattr("robotcore.runtime.wait_monitor.read_queue_time", lambda: 0.95 * clock[0])
    monitor = WaitMonitor(reported.append)
    monitor.begin()
    clock[0] += 10.0
    monitor.end(0.1)
    assert reported == []


@pytest.mark.slow  # a note needs more than a second
def test_run_in_a_simulation_reports_steps_that_sleep(capfd: pytest.CaptureFixture[str]) -> None:
    def sleep(robot: Robot) -> Status:
        time.sleep(1.1)
        return Status.SUCCESS

    result = run(RunRequest(FunctionApp(sleep)))
    assert [isinstance(note, WrittenNote) for note in result.notes] == [True]
    write_result(result, as_json=False)
    assert capfd.readouterr().err.count("note: ") == 1
