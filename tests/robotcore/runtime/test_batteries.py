"""Batteries in whole runs: who opens them, and what a run tells of them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from drivers.mock.devices import Script
from robotcore.description import RobotDescription
from robotcore.errors import DeviceLostError
from robotcore.runtime.session import RunRequest, RunResult, run
from tests.doubles import powered
from tests.robotcore.runs import Watcher


@pytest.fixture
def rover(tmp_path: Path) -> RobotDescription:
    return powered.powered_rover(tmp_path)


def ran(rover: RobotDescription, backend: str = "powered", **asked: object) -> RunResult:
    settings = {"duration_s": 6.0}
    return run(RunRequest("avoid-obstacles", backend, str(rover.file), "open", settings=settings, **asked))  # type: ignore[arg-type]


def fed_by(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription, volts: Script) -> RunResult:
    powered.install(monkeypatch, volts)
    return ran(rover)


def test_the_result_tells_the_lowest_and_the_last_voltage(
    monkeypatch: pytest.MonkeyPatch, rover: RobotDescription
) -> None:
    result = fed_by(monkeypatch, rover, lambda time: 7.4 - time % 3 / 10)
    assert result.batteries == {"cells": {"lowest_v": 7.2, "last_v": 7.4}}
    assert json.loads(result.to_json())["batteries"]["cells"]["lowest_v"] == 7.2


def test_a_low_battery_is_a_note_and_no_failure(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription) -> None:
    result = fed_by(monkeypatch, rover, 6.0)
    assert result.exit_status == 0
    assert result.notes == ["cells: 6.00 V, and it is to be charged below 6.6 V. Charge it"]


@pytest.mark.parametrize("volts", [6.0, lambda time: 12.0 - time, DeviceLostError("cells", "unplugged"), None])
def test_no_decision_depends_on_it(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription, volts: Script) -> None:
    without = ran(rover, "kinematic")
    told = fed_by(monkeypatch, rover, volts)
    assert (told.trace_sha256, told.ticks, told.outcome) == (without.trace_sha256, without.ticks, without.outcome)


def test_a_battery_that_cannot_be_opened_is_a_note(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription) -> None:
    result = fed_by(monkeypatch, rover, None)
    assert (result.exit_status, result.notes, result.batteries) == (0, ["cells: no answer"], {})


@pytest.mark.parametrize("backend", ["kinematic", "pybullet", "mock"])
def test_a_simulator_has_none_and_makes_none_up(rover: RobotDescription, backend: str) -> None:
    if backend == "pybullet":
        pytest.importorskip("pybullet")
    result = ran(rover, backend, timeout_s=0.5)
    assert (result.error, result.batteries) == (None, {})


def test_a_battery_can_be_lost_on_purpose(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription) -> None:
    powered.install(monkeypatch)
    watcher = Watcher()
    request = RunRequest("avoid-obstacles", "powered", str(rover.file), "open", timeout_s=1.2, faults=("cells lost=1",))
    run(request, [watcher])
    voltages = [told.voltages for what, told in watcher.heard if what == "tick"]
    assert [bool(each) for each in voltages] == [tick >= 20 for tick in range(25)]
