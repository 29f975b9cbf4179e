from __future__ import annotations

from pathlib import Path
from unittest.mock import create_autospec

import pytest

from apps.avoid_obstacles import AvoidObstacles
from robotcore import Outcome, RunRequest, Truth, run
from robotcore.description import load_robot
from robotcore.testing import MockRobot

ROBOTS = Path(__file__).parents[2] / "robotcore" / "description" / "robots"


@pytest.fixture
def narrow(tmp_path: Path) -> str:
    """The rover with a cone of 15°."""
    text = (ROBOTS / "rover.toml").read_text()
    file = tmp_path / "narrow.toml"
    file.write_text(text.replace("cone_rad = 0.5236", "cone_rad = 0.2618"))
    assert load_robot(str(file)) != load_robot("rover")
    return str(file)


def test_drives_for_ten_seconds_by_default() -> None:
    result = run(RunRequest("avoid-obstacles", world="open"))
    assert result.outcome is Outcome.SUCCESS
    assert result.sim_time_s == pytest.approx(10.0)


@pytest.mark.slow
@pytest.mark.parametrize("world, seed", [("arena", 3), ("clutter", 4), ("occluded", 5)])
def test_wanders_without_a_contact_with_a_narrow_cone(narrow: str, world: str, seed: int) -> None:
    result = run(RunRequest("avoid-obstacles", robot=narrow, world=world, seed=seed, settings={"duration_s": 60}))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0)
    assert list(result.milestones) == ["look", "turn", "cruise"]


@pytest.mark.slow
def test_readings_that_arrive_late_show_no_corridor_beside_the_free_one() -> None:
    settings = {"duration_s": 25}
    result = run(RunRequest("avoid-obstacles", seed=7, faults=("nose delay=0.2",), settings=settings))
    assert (result.outcome, result.contacts) == (Outcome.SUCCESS, 0)


@pytest.mark.parametrize("contacts", [0, 1])
def test_only_a_run_without_contacts_is_verified(contacts: int) -> None:
    truth = create_autospec(Truth, instance=True, contacts=contacts)
    assert AvoidObstacles().verify(truth) is (contacts == 0)


def test_robot_in_a_closed_circle_only_turns() -> None:
    robot = MockRobot(range=0.05)
    robot.run(AvoidObstacles(duration_s=20.0), ticks=300)
    assert all(wheels.left == -wheels.right for wheels in robot.wheels)


def test_obstacle_that_appears_ahead_ends_the_drive() -> None:
    app = AvoidObstacles()
    robot = MockRobot(range=[2.0] * 120 + [0.25])
    robot.run(app, ticks=120)
    assert app.state == "cruise"
    assert min(robot.wheels[-1]) > 0
    robot.run(app, ticks=1)
    assert app.state == "look"
