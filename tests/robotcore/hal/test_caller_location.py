from __future__ import annotations

import math
from pathlib import Path

import pytest

from robotcore.errors import InvalidCommandError
from robotcore.geometry import Wheels
from robotcore.hal.device import caller_location
from robotcore.hal.robot import Robot
from robotcore.runtime.result import Outcome
from robotcore.safety.velocity_limits import VelocityLimit
from tests.robotcore.runs import Runner, drive_then, drive_wheels


def test_caller_location_is_the_file_and_line_of_the_caller() -> None:
    file, line = caller_location().split(":")
    assert (file, line.isdigit()) == (Path(__file__).name, True)


@pytest.mark.parametrize("is_caught", [False, True])
def test_error_for_a_nan_velocity_names_the_apps_line(perform: Runner, *, is_caught: bool) -> None:
    def command_nan(robot: Robot) -> None:
        try:
            drive_wheels(robot, math.nan)
        except InvalidCommandError:
            if not is_caught:
                raise

    result = perform(drive_then(command_nan))
    assert result.outcome is Outcome.STOPPED
    assert "left_motor: the app commanded a velocity of nan rad/s, at runs.py:" in result.reason


def test_error_for_a_nan_of_the_framework_names_no_line(monkeypatch: pytest.MonkeyPatch, perform: Runner) -> None:
    monkeypatch.setattr(VelocityLimit, "__call__", lambda *_: Wheels(math.nan, math.nan))
    assert "left_motor: the app commanded a velocity of nan rad/s, and all" in perform(drive_then(drive_wheels)).reason
