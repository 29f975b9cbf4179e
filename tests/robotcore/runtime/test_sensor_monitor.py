"""The monitor of sensors, alone and in whole runs."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.kind import build_sensor
from robotcore.hal.robot import Robot
from robotcore.kinds.battery import BatteryDescription, Voltage
from robotcore.kinds.line_sensor import Darkness
from robotcore.runtime.behaviour import Status
from robotcore.runtime.sensor_monitor import PROBLEM_S, SensorMonitor, find_number
from robotcore.runtime.session import RunRequest, RunResult, run
from robotcore.runtime.trace import TickRecord, Trace, format_monitored
from robotcore.testing.mock.devices import LOST, Script
from robotcore.testing.mock.robot import MockRobot
from tests.doubles import battery_backend, foreign_kinds
from tests.doubles.foreign_kinds import Temperature, ThermometerDescription
from tests.robotcore.fakes import FunctionApp
from tests.texts import CheckText

ROVER = load_robot("rover")


def run_with_voltage(volts: Script, seconds: float) -> MockRobot:
    """Run an app that reads nothing on a robot whose battery has this voltage, and a warning below 6.6 V."""
    battery = BatteryDescription(kind="battery", name="cells", warn_below_v=6.6)
    description = ROVER.model_copy(update={"devices": (*ROVER.devices, battery)})
    robot, app = MockRobot(description, readings={"cells": volts}), FunctionApp(lambda _: Status.RUNNING)
    app.needs = frozenset()  # type: ignore[misc]
    assert robot.run(app, int(seconds * robot.rate_hz)) is Status.RUNNING
    return robot


def test_battery_is_read_once_a_second_even_if_the_app_reads_nothing() -> None:
    robot = run_with_voltage(lambda time: 7.0 + time, 2.5)
    assert {round(tick.monitored["cells"].value, 6) for tick in robot.ticks} == {7.0, 8.0, 9.0}


BROKEN = DeviceError("cells", "no answer")


@pytest.mark.parametrize(
    "volts, warned_at, last_v",
    [
        (lambda time: 7.0 if time < 2 else 6.4, [1.0 + PROBLEM_S], 6.4),
        (lambda time: 6.0 if time % 3 else 7.0, [], 6.0),
        (6.0, [0.0], 6.0),
        (lambda time: BROKEN if 2 <= time < 4 or time > 6 else 7.0 + time / 10, [2.0], 7.6),
        ([6.7, LOST], [], 6.7),
    ],
    ids=["low", "low for moments", "low from the start", "failing", "old"],
)
def test_lasting_low_voltage_or_failure_causes_one_warning_and_ends_no_run(
    volts: Script, warned_at: list[float], last_v: float, check_text: CheckText
) -> None:
    robot = run_with_voltage(volts, 12.0)
    warnings = [(round(tick.time, 6), warning) for tick in robot.ticks for warning in tick.warnings]
    assert [time for time, _ in warnings] == warned_at
    for _, warning in warnings:
        check_text(warning)
    assert robot.ticks[-1].monitored["cells"].value == pytest.approx(last_v)


def test_voltage_that_is_not_finite_causes_a_warning_and_is_left_out(check_text: CheckText) -> None:
    cells = build_sensor(BatteryDescription(kind="battery", name="cells"), lambda: Voltage(math.nan, 0.0, 0))
    monitor = SensorMonitor(Robot("rover", SteppedClock(20.0, lambda _steps: None), [cells]))
    (warning,) = monitor.read(0.0)
    check_text(warning)
    assert monitor.values == {}


def test_sensor_of_another_package_is_monitored_in_its_own_unit(monkeypatch: pytest.MonkeyPatch) -> None:
    foreign_kinds.install(monkeypatch)
    engine = build_sensor(ThermometerDescription(name="engine"), lambda: Temperature("front", 90.0, 4.0, 1))
    monitor = SensorMonitor(Robot("rover", SteppedClock(20.0, lambda _steps: None), [engine]))
    assert monitor.read(0.0) == ("engine: Let the motor cool down",)
    assert format_monitored(monitor.values) == "90.00 °C"
    trace = Trace(())
    trace.add(TickRecord(0, 0.0, "", None, None, (), monitored=monitor.values))
    assert trace.voltages == {}


def test_sensor_whose_class_fails_causes_one_warning(monkeypatch: pytest.MonkeyPatch, check_text: CheckText) -> None:
    foreign_kinds.install(monkeypatch)
    engine = build_sensor(ThermometerDescription(name="engine"), lambda: Temperature("front", 90.0, 4.0, 1))
    monkeypatch.setattr(engine, "find_problem", lambda _sample: 1 / 0)
    monitor = SensorMonitor(Robot("rover", SteppedClock(20.0, lambda _steps: None), [engine]))
    check_text("\n".join(monitor.read(0.0)))
    assert monitor.read(5.0) == ()


def test_monitored_sensor_whose_samples_have_no_number_has_no_value() -> None:
    assert find_number(Darkness((0.5, 0.5), 0.0, 0)) is None


@pytest.fixture
def rover(tmp_path: Path) -> RobotDescription:
    return battery_backend.load_battery_rover(tmp_path)


def run_rover(rover: RobotDescription, backend: str = "powered") -> RunResult:
    return run(RunRequest("avoid-obstacles", backend, str(rover.file), "open", settings={"duration_s": 6.0}))


def test_result_has_the_lowest_and_the_last_voltage(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription) -> None:
    battery_backend.install(monkeypatch, lambda time: 7.4 - time % 3 / 10)
    result = run_rover(rover)
    assert result.batteries == {"cells": {"lowest_v": 7.2, "last_v": 7.4}}
    assert json.loads(result.to_json())["batteries"]["cells"]["lowest_v"] == 7.2


@pytest.mark.parametrize("volts", [6.0, lambda time: 12.0 - time, DeviceLostError("cells", "unplugged"), None])
def test_no_decision_depends_on_the_voltage(
    monkeypatch: pytest.MonkeyPatch, rover: RobotDescription, volts: Script
) -> None:
    without = run_rover(rover, "kinematic")
    battery_backend.install(monkeypatch, volts)
    result = run_rover(rover)
    assert (result.trace_sha256, result.ticks, result.outcome) == (without.trace_sha256, without.ticks, without.outcome)


def test_battery_that_cannot_be_opened_is_a_note(monkeypatch: pytest.MonkeyPatch, rover: RobotDescription) -> None:
    battery_backend.install(monkeypatch, None)
    result = run_rover(rover)
    assert (result.exit_status, result.notes, result.batteries) == (0, ["cells: no answer"], {})
