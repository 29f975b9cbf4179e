"""The battery monitor, alone and in whole runs."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from robotcore.description import BatteryDescription, RobotDescription, load_robot
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.runtime.behaviour import Status
from robotcore.runtime.monitors import LOW_VOLTAGE_S
from robotcore.runtime.session import RunRequest, RunResult, run
from robotcore.testing.mock.devices import LOST, Script
from robotcore.testing.mock.robot import MockRobot
from tests.doubles import battery_backend
from tests.robotcore.fakes import FunctionApp
from tests.texts import CheckText

ROVER = load_robot("rover")


def robot_with_voltage(volts: Script, warn_below_v: float | None = 6.6) -> MockRobot:
    battery = BatteryDescription(kind="battery", name="cells", warn_below_v=warn_below_v)
    robot = ROVER.model_copy(update={"devices": (*ROVER.devices, battery)})
    return MockRobot(robot, readings={"cells": volts})


class Idle(FunctionApp):
    """An app that needs no device and never ends."""

    needs = frozenset()

    def __init__(self) -> None:
        super().__init__(lambda _: Status.RUNNING)


def after(seconds: float, robot: MockRobot) -> MockRobot:
    assert robot.run(Idle(), int(seconds * robot.rate_hz)) is Status.RUNNING
    return robot


def warnings(robot: MockRobot) -> list[tuple[float, str]]:
    return [(round(tick.time, 6), warning) for tick in robot.ticks for warning in tick.warnings]


def test_battery_is_read_once_a_second_even_if_the_app_reads_nothing() -> None:
    robot = after(2.5, robot_with_voltage(lambda time: 7.0 + time))
    voltages = {round(tick.voltages["cells"], 6) for tick in robot.ticks}
    assert voltages == {7.0, 8.0, 9.0}


def test_lasting_low_voltage_causes_one_warning(check_text: CheckText) -> None:
    robot = after(12.0, robot_with_voltage(lambda time: 7.0 if time < 2 else 6.4))
    ((when, warning),) = warnings(robot)
    assert when == 1.0 + LOW_VOLTAGE_S
    check_text(warning)


def test_low_voltage_for_a_moment_causes_no_warning() -> None:
    assert warnings(after(12.0, robot_with_voltage(lambda time: 6.0 if time % 3 else 7.0))) == []


def test_low_voltage_at_the_start_causes_a_warning_at_once() -> None:
    assert [when for when, _ in warnings(after(9.0, robot_with_voltage(6.0)))] == [0.0]


def test_failing_battery_is_reported_once_and_the_run_continues(check_text: CheckText) -> None:
    broken = DeviceError("cells", "no answer")
    robot = after(9.0, robot_with_voltage(lambda time: broken if 2 <= time < 4 or time > 6 else 7.0 + time / 10))
    assert [when for when, _ in warnings(robot)] == [2.0]
    check_text(warnings(robot)[0][1])
    assert robot.ticks[-1].voltages["cells"] == pytest.approx(7.6)


def test_voltage_that_is_nan_is_never_reported(check_text: CheckText) -> None:
    robot = after(3.0, robot_with_voltage(math.nan))
    ((_, warning),) = warnings(robot)
    check_text(warning)
    assert robot.ticks[-1].voltages == {}


def test_old_voltage_ends_no_run_and_causes_no_warning() -> None:
    assert ROVER.safety.max_age_s < 4.0
    robot = after(5.0, robot_with_voltage([6.7, LOST]))
    assert robot.ticks[-1].voltages == {"cells": 6.7}
    assert warnings(robot) == []


@pytest.fixture
def rover(tmp_path: Path) -> RobotDescription:
    return battery_backend.load_battery_rover(tmp_path)


def run_rover(rover: RobotDescription, backend: str = "powered", **asked: object) -> RunResult:
    settings = {"duration_s": 6.0}
    return run(RunRequest("avoid-obstacles", backend, str(rover.file), "open", settings=settings, **asked))  # type: ignore[arg-type]


def run_with_voltage(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription, volts: Script) -> RunResult:
    battery_backend.install(monkeypatch, volts)
    return run_rover(rover)


def test_result_has_the_lowest_and_the_last_voltage(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription) -> None:
    result = run_with_voltage(monkeypatch, rover, lambda time: 7.4 - time % 3 / 10)
    assert result.batteries == {"cells": {"lowest_v": 7.2, "last_v": 7.4}}
    assert json.loads(result.to_json())["batteries"]["cells"]["lowest_v"] == 7.2


@pytest.mark.parametrize("volts", [6.0, lambda time: 12.0 - time, DeviceLostError("cells", "unplugged"), None])
def test_no_decision_depends_on_the_voltage(
    monkeypatch: pytest.MonkeyPatch, rover: RobotDescription, volts: Script
) -> None:
    without = run_rover(rover, "kinematic")
    result = run_with_voltage(monkeypatch, rover, volts)
    assert (result.trace_sha256, result.ticks, result.outcome) == (without.trace_sha256, without.ticks, without.outcome)


def test_battery_that_cannot_be_opened_is_a_note(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription) -> None:
    result = run_with_voltage(monkeypatch, rover, None)
    assert (result.exit_status, result.notes, result.batteries) == (0, ["cells: no answer"], {})
