"""Apps on robots whose wheels skid or steer."""

from __future__ import annotations

import pytest

from apps.avoid_obstacles import AvoidObstacles
from robotcore import RunRequest, run
from robotcore.description import load_robot
from robotcore.errors import UsageError
from robotcore.runtime.plan import Plan
from robotcore.testing import MockRobot
from tests.texts import Raises


@pytest.mark.parametrize("app", ["green-search", "avoid-obstacles"])
def test_app_that_turns_on_the_spot_is_refused_for_a_robot_that_steers(app: str, raises: Raises) -> None:
    with raises(UsageError, "no-turn-on-spot", radius_m=load_robot("picar").min_turn_radius_m):
        Plan.resolve(RunRequest(app, robot="picar"))
    assert Plan.resolve(RunRequest(app, robot="freenove-4wd"))


def test_mock_robot_that_steers_refuses_an_app_that_turns_on_the_spot(raises: Raises) -> None:
    with raises(UsageError, "no-turn-on-spot"):
        MockRobot("picar", range=1.0).run(AvoidObstacles())


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet"])
def test_robot_that_skids_finds_the_ball(backend: str) -> None:
    assert run(RunRequest("green-search", backend, robot="freenove-4wd", world="arena", seed=3)).verified


@pytest.mark.slow
@pytest.mark.parametrize("robot", ["freenove-4wd", "picar"])
def test_robot_follows_a_line_and_searches_a_lost_one(robot: str) -> None:
    result = run(RunRequest("follow-line", robot=robot, world="track", seed=2))
    assert result.verified
    assert "search" in result.milestones
