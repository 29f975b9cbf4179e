"""The battery monitor, alone and in whole runs."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from robotcore.description import BatteryDescription, RobotDescription, load_robot
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.monitors import PATIENCE_S
from robotcore.runtime.session import RunRequest, RunResult, run
from robotcore.testing.mock.devices import LOST, Script
from robotcore.testing.mock.robot import MockRobot
from tests.doubles import powered
from tests.robotcore.fakes import Deed
from tests.robotcore.runs import Watcher

ROVER = load_robot("rover")


def robot_with_voltage(volts: Script, warn_below_v: float | None = 6.6) -> MockRobot:
    battery = BatteryDescription(kind="battery", name="cells", warn_below_v=warn_below_v)
    robot = ROVER.model_copy(update={"devices": (*ROVER.devices, battery)})
    return MockRobot(robot, readings={"cells": volts})


class Idle(Deed):
    """Needs nothing, and waits."""

    needs = frozenset()

    def __init__(self) -> None:
        super().__init__(lambda _: Status.RUNNING)


def after(seconds: float, robot: MockRobot) -> MockRobot:
    assert robot.run(Idle(), int(seconds * robot.rate_hz)) is Status.RUNNING
    return robot


def warnings(robot: MockRobot) -> list[tuple[float, str]]:
    return [(round(tick.time, 6), warning) for tick in robot.ticks for warning in tick.warnings]


def test_it_is_read_once_a_second_though_the_app_asks_for_nothing() -> None:
    robot = after(2.5, robot_with_voltage(lambda time: 7.0 + time))
    voltages = {round(tick.voltages["cells"], 6) for tick in robot.ticks}
    assert voltages == {7.0, 8.0, 9.0}


def test_a_low_voltage_that_stays_is_warned_of_once_after_a_while() -> None:
    robot = after(12.0, robot_with_voltage(lambda time: 7.0 if time < 2 else 6.4))
    ((when, warning),) = warnings(robot)
    assert when == 1.0 + PATIENCE_S
    assert warning == "cells: 6.40 V, and it is to be charged below 6.6 V. Charge it"


def test_motors_that_pull_it_down_for_a_moment_are_no_reason_to_warn() -> None:
    assert warnings(after(12.0, robot_with_voltage(lambda time: 6.0 if time % 3 else 7.0))) == []


def test_a_battery_that_is_low_before_anything_turns_is_warned_of_at_once() -> None:
    assert [when for when, _ in warnings(after(9.0, robot_with_voltage(6.0)))] == [0.0]


def test_where_nobody_gives_a_limit_nothing_is_warned_of() -> None:
    assert warnings(after(9.0, robot_with_voltage(1.0, warn_below_v=None))) == []


def test_a_battery_that_fails_is_reported_once_and_the_run_goes_on() -> None:
    broken = DeviceError("cells", "no answer")
    robot = after(9.0, robot_with_voltage(lambda time: broken if 2 <= time < 4 or time > 6 else 7.0 + time / 10))
    assert [when for when, _ in warnings(robot)] == [2.0]
    assert warnings(robot)[0][1].startswith("cells: ")
    assert warnings(robot)[0][1].endswith("The run goes on: nobody drives by it")
    assert robot.ticks[-1].voltages["cells"] == pytest.approx(7.6)


def test_what_is_no_number_is_never_reported() -> None:
    robot = after(3.0, robot_with_voltage(math.nan))
    assert [warning for _, warning in warnings(robot)] == [
        "cells: nan V is no voltage. Report it to whoever wrote its driver. The run goes on: nobody drives by it"
    ]
    assert robot.ticks[-1].voltages == {}


def test_a_voltage_that_grows_old_stops_nobody_and_warns_of_nothing() -> None:
    assert ROVER.safety.max_age_s < 4.0
    robot = after(5.0, robot_with_voltage([6.7, LOST]))
    assert robot.ticks[-1].voltages == {"cells": 6.7}
    assert warnings(robot) == []


def test_one_low_voltage_however_old_is_not_one_that_stays() -> None:
    assert warnings(after(9.0, robot_with_voltage(lambda time: 7.0 if time < 1 else 6.0 if time < 1.1 else LOST))) == []


def test_an_app_may_read_it_by_its_name() -> None:
    seen: list[float] = []

    def reading(robot: Robot) -> Status:
        seen.append(robot["cells"].read().voltage)  # type: ignore[attr-defined]  # it is a Battery
        return Status.RUNNING

    robot_with_voltage([7.4, 7.3]).run(Deed(reading), 3)
    assert seen == [7.4, 7.3, 7.3]


def test_a_mock_without_a_script_has_no_battery() -> None:
    battery = BatteryDescription(kind="battery", name="cells")
    robot = MockRobot(ROVER.model_copy(update={"devices": (*ROVER.devices, battery)}))
    assert "cells" not in robot.layered.devices
    assert after(1.0, robot).ticks[-1].voltages == {}


@pytest.fixture
def rover(tmp_path: Path) -> RobotDescription:
    return powered.powered_rover(tmp_path)


def run_rover(rover: RobotDescription, backend: str = "powered", **asked: object) -> RunResult:
    settings = {"duration_s": 6.0}
    return run(RunRequest("avoid-obstacles", backend, str(rover.file), "open", settings=settings, **asked))  # type: ignore[arg-type]


def run_with_voltage(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription, volts: Script) -> RunResult:
    powered.install(monkeypatch, volts)
    return run_rover(rover)


def test_the_result_tells_the_lowest_and_the_last_voltage(
    monkeypatch: pytest.MonkeyPatch, rover: RobotDescription
) -> None:
    result = run_with_voltage(monkeypatch, rover, lambda time: 7.4 - time % 3 / 10)
    assert result.batteries == {"cells": {"lowest_v": 7.2, "last_v": 7.4}}
    assert json.loads(result.to_json())["batteries"]["cells"]["lowest_v"] == 7.2


def test_a_low_battery_is_a_note_and_no_failure(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription) -> None:
    result = run_with_voltage(monkeypatch, rover, 6.0)
    assert result.exit_status == 0
    assert result.notes == ["cells: 6.00 V, and it is to be charged below 6.6 V. Charge it"]


@pytest.mark.parametrize("volts", [6.0, lambda time: 12.0 - time, DeviceLostError("cells", "unplugged"), None])
def test_no_decision_depends_on_it(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription, volts: Script) -> None:
    without = run_rover(rover, "kinematic")
    result = run_with_voltage(monkeypatch, rover, volts)
    assert (result.trace_sha256, result.ticks, result.outcome) == (without.trace_sha256, without.ticks, without.outcome)


def test_a_battery_that_cannot_be_opened_is_a_note(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription) -> None:
    result = run_with_voltage(monkeypatch, rover, None)
    assert (result.exit_status, result.notes, result.batteries) == (0, ["cells: no answer"], {})


@pytest.mark.parametrize("backend", ["kinematic", "pybullet", "mock"])
def test_a_simulator_has_none_and_makes_none_up(rover: RobotDescription, backend: str) -> None:
    if backend == "pybullet":
        pytest.importorskip("pybullet")
    result = run_rover(rover, backend, timeout_s=0.5)
    assert (result.error, result.batteries) == (None, {})


def test_a_battery_can_be_lost_on_purpose(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription) -> None:
    powered.install(monkeypatch)
    watcher = Watcher()
    request = RunRequest("avoid-obstacles", "powered", str(rover.file), "open", timeout_s=1.2, faults=("cells lost=1",))
    run(request, [watcher])
    voltages = [value.voltages for what, value in watcher.heard if what == "tick"]
    assert [bool(each) for each in voltages] == [tick >= 20 for tick in range(25)]
