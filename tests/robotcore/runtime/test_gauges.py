"""A battery beside the app: read now and then, warned of once, and nobody stops for it."""

from __future__ import annotations

import math

import pytest

from drivers.mock import LOST, MockRobot
from drivers.mock.devices import Script
from robotcore.description import BatteryDescription, load_robot
from robotcore.errors import DeviceError
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.monitors import PATIENCE_S
from tests.robotcore.fakes import Deed

ROVER = load_robot("rover")


def fed_by(volts: Script, warn_below_v: float | None = 6.6) -> MockRobot:
    told = BatteryDescription(kind="battery", name="cells", warn_below_v=warn_below_v)
    robot = ROVER.model_copy(update={"devices": (*ROVER.devices, told)})
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
    return [(round(tick.time, 6), told) for tick in robot.ticks for told in tick.warnings]


def test_it_is_read_once_a_second_though_the_app_asks_for_nothing() -> None:
    robot = after(2.5, fed_by(lambda time: 7.0 + time))
    told = {round(tick.voltages["cells"], 6) for tick in robot.ticks}
    assert told == {7.0, 8.0, 9.0}


def test_a_low_voltage_that_stays_is_warned_of_once_after_a_while() -> None:
    robot = after(12.0, fed_by(lambda time: 7.0 if time < 2 else 6.4))
    ((when, told),) = warnings(robot)
    assert when == 1.0 + PATIENCE_S
    assert told == "cells: 6.40 V, and it is to be charged below 6.6 V. Charge it"


def test_motors_that_pull_it_down_for_a_moment_are_no_reason_to_warn() -> None:
    assert warnings(after(12.0, fed_by(lambda time: 6.0 if time % 3 else 7.0))) == []


def test_a_battery_that_is_low_before_anything_turns_is_warned_of_at_once() -> None:
    assert [when for when, _ in warnings(after(9.0, fed_by(6.0)))] == [0.0]


def test_where_nobody_gives_a_limit_nothing_is_warned_of() -> None:
    assert warnings(after(9.0, fed_by(1.0, warn_below_v=None))) == []


def test_a_battery_that_fails_is_told_once_and_the_run_goes_on() -> None:
    broken = DeviceError("cells", "no answer")
    robot = after(9.0, fed_by(lambda time: broken if 2 <= time < 4 or time > 6 else 7.0 + time / 10))
    assert [when for when, _ in warnings(robot)] == [2.0]
    assert warnings(robot)[0][1].startswith("cells: ")
    assert warnings(robot)[0][1].endswith("The run goes on: nobody drives by it")
    assert robot.ticks[-1].voltages["cells"] == pytest.approx(7.6)


def test_what_is_no_number_is_never_told() -> None:
    robot = after(3.0, fed_by(math.nan))
    assert [told for _, told in warnings(robot)] == [
        "cells: nan V is no voltage. Report it to whoever wrote its driver. The run goes on: nobody drives by it"
    ]
    assert robot.ticks[-1].voltages == {}


def test_a_voltage_that_grows_old_stops_nobody_and_warns_of_nothing() -> None:
    assert ROVER.safety.max_age_s < 4.0
    robot = after(5.0, fed_by([6.7, LOST]))
    assert robot.ticks[-1].voltages == {"cells": 6.7}
    assert warnings(robot) == []


def test_one_low_voltage_however_old_is_not_one_that_stays() -> None:
    assert warnings(after(9.0, fed_by(lambda time: 7.0 if time < 1 else 6.0 if time < 1.1 else LOST))) == []


def test_an_app_may_read_it_by_its_name() -> None:
    seen: list[float] = []

    def reading(robot: Robot) -> Status:
        seen.append(robot["cells"].read().voltage)  # type: ignore[attr-defined]  # it is a Battery
        return Status.RUNNING

    fed_by([7.4, 7.3]).run(Deed(reading), 3)
    assert seen == [7.4, 7.3, 7.3]


def test_a_mock_without_a_script_has_no_battery() -> None:
    told = BatteryDescription(kind="battery", name="cells")
    robot = MockRobot(ROVER.model_copy(update={"devices": (*ROVER.devices, told)}))
    assert "cells" not in robot.layered.devices
    assert after(1.0, robot).ticks[-1].voltages == {}
