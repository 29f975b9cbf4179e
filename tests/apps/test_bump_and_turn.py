"""The app drives by its bumpers alone."""

from __future__ import annotations

import pytest

from apps.bump_and_turn import BumpAndTurn
from robotcore import Outcome, RunRequest, Status, run
from robotcore.testing import MockRobot


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet", "virtualpi"])
def test_robot_touches_three_obstacles_and_stops(backend: str) -> None:
    result = run(RunRequest("bump-and-turn", robot="tracer", world="arena", backend=backend, seed=1))
    assert (result.outcome, result.verified) == (Outcome.SUCCESS, True)
    assert list(result.milestones) == ["drive", "back", "turn"]


@pytest.mark.parametrize("bumper, side", [("left_bumper", -1), ("right_bumper", 1)])
def test_robot_backs_off_and_turns_away_from_the_contact(bumper: str, side: int) -> None:
    robot = MockRobot("tracer", readings={bumper: lambda time: 0.2 < time < 0.3})
    app = BumpAndTurn()
    robot.run(app, ticks=12)
    assert app.state == "back"
    assert robot.wheels[-1].left < 0 > robot.wheels[-1].right
    robot.run(app, ticks=12)
    assert app.state == "turn"
    assert side * (robot.wheels[-1].right - robot.wheels[-1].left) > 0
    assert robot.run(app, ticks=40) is Status.RUNNING
    assert app.state == "drive"
