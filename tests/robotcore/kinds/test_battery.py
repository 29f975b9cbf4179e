"""A run reads a battery by itself where the backend can, and simulators have none."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from robotcore import Behaviour, Robot, Role, RunRequest, Status
from robotcore.errors import UsageError
from robotcore.kinds import Battery
from robotcore.runtime.plan import Plan
from robotcore.testing import MockRobot
from tests.doubles.battery_backend import load_battery_rover
from tests.texts import Raises


class Idle(Behaviour):
    needs: ClassVar = {Role.DRIVE}

    def step(self, robot: Robot) -> Status:
        return Status.SUCCESS


class Needing(Idle):
    needs: ClassVar = {Battery}


class Wanting(Idle):
    wants: ClassVar = {Battery}


def test_app_that_needs_a_battery_is_refused_in_a_simulator(tmp_path: Path, raises: Raises) -> None:
    rover = str(load_battery_rover(tmp_path).file)
    with raises(UsageError, "device-not-openable", device="cells"):
        Plan.resolve(RunRequest(Needing, robot=rover, world="open"))


def test_app_that_needs_a_battery_is_refused_by_a_mock_robot_without_its_script(tmp_path: Path, raises: Raises) -> None:
    rover = load_battery_rover(tmp_path)
    with raises(UsageError, "device-not-openable", device="cells"):
        MockRobot(rover).run(Needing())
    assert MockRobot(rover, readings={"cells": 7.4}).run(Needing()) is Status.SUCCESS


def test_app_that_wants_a_battery_runs_in_a_simulator_without_it(tmp_path: Path) -> None:
    rover = str(load_battery_rover(tmp_path).file)
    assert "cells" not in Plan.resolve(RunRequest(Wanting, robot=rover, world="open")).setup.devices
