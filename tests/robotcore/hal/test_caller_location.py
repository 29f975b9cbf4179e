"""test_caller_location."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from robotcore.errors import InvalidCommandError
from robotcore.geometry import Wheels
from robotcore.hal.devices import caller_location
from robotcore.hal.robot import Robot
from robotcore.runtime.result import Outcome
from robotcore.safety.velocity_limits import VelocityLimit
from tests.robotcore.runs import Runner, drive_then, drive_wheels


def test_whoever_calls_the_framework_is_reported_by_line() -> None:
    file, line = caller_location().split(":")
    assert (file, line.isdigit()) == (Path(__file__).name, True)


@pytest.mark.parametrize("is_swallowed", [False, True])
def test_an_app_that_asks_for_no_number_is_reported_where(perform: Runner, *, is_swallowed: bool) -> None:
    def ask(robot: Robot) -> None:
        try:
            drive_wheels(robot, math.nan)
        except InvalidCommandError:
            if not is_swallowed:
                raise

    result = perform(drive_then(ask))
    assert result.outcome is Outcome.STOPPED
    assert "left_motor: a velocity of nan rad/s was asked for, at runs.py:" in result.reason


def test_what_the_framework_asks_of_itself_has_no_line_of_an_app(
    monkeypatch: pytest.MonkeyPatch, perform: Runner
) -> None:
    monkeypatch.setattr(VelocityLimit, "__call__", lambda *_: Wheels(math.nan, math.nan))
    assert "left_motor: a velocity of nan rad/s was asked for; it must be" in perform(drive_then(drive_wheels)).reason
