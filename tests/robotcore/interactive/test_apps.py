"""An app in a session has the checks and the end of an app in a run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import robotcore
from robotcore import Behaviour, Robot, Role, Routine, RunRequest, Status, run, wait
from robotcore.errors import BehaviourError, InvalidCommandError
from robotcore.recording import read


class App(Behaviour):
    needs = frozenset({Role.DRIVE, Role.RANGE})


class StepReturnsNumber(App):
    def step(self, robot: Robot) -> Any:
        return 3


class RunReturnsNothing(App):
    def run(self, robot: Robot) -> Any:
        yield


class RunReturnsNumber(App):
    def run(self, robot: Robot) -> Any:
        return 3


class Nod(App):
    def __init__(self, velocity: float = 0.1) -> None:
        self.velocity, self.has_cleaned_up = velocity, False

    def run(self, robot: Robot) -> Routine[Status]:
        try:
            yield from wait(robot, 0.1)
            robot.drive.set_velocity(self.velocity, 0.0)
            yield
            return Status.SUCCESS
        finally:
            self.has_cleaned_up = True


@pytest.mark.parametrize("app", [StepReturnsNumber, RunReturnsNothing, RunReturnsNumber])
def test_wrong_result_is_the_error_of_a_run(app: type[App]) -> None:
    expected = run(RunRequest(app, world="open")).error
    assert isinstance(expected, BehaviourError)
    with robotcore.open(world="open") as robot, pytest.raises(BehaviourError) as caught:
        robot.run(app())
    assert (str(caught.value), caught.value.kind) == (str(expected), expected.kind)


def test_app_that_contains_another_one_gets_its_wrong_result() -> None:
    with robotcore.open(world="open") as robot, pytest.raises(BehaviourError, match=r"Number\.step returned 3"):
        robot.run(StepReturnsNumber().run(robot))


def test_app_cleans_up_after_an_error_of_the_safety_stage() -> None:
    app = Nod(math.nan)
    with robotcore.open(world="open") as robot, pytest.raises(InvalidCommandError):
        robot.run(app)
    assert app.has_cleaned_up
    assert not app.has_open_routine


def test_app_runs_twice_and_its_name_is_recorded(tmp_path: Path) -> None:
    file, app = tmp_path / "session.mcap", Nod()
    with robotcore.open(world="open", record=file) as robot:
        assert robot.run(app) is robot.run(app) is Status.SUCCESS
    assert {tick.state for tick in read(file).ticks} == {"wait", "Nod"}
