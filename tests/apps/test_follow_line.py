"""The app follows the line of the world track, and the simulator verifies it by the robot's true way."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar
from unittest.mock import create_autospec

import cv2
import numpy as np
import pytest

from apps.follow_line import FollowLine
from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, RunResult, Status, Truth, run
from robotcore.runtime.observer import RunContext
from robotcore.runtime.trace import TickRecord
from robotcore.testing import MockRobot

WHITE, LEFT, MIDDLE = (0, 0, 0, 0, 0), (1, 0, 0, 0, 0), (0, 0, 1, 0, 0)


def follow(backend: str = "kinematic", seed: int | None = None, fault: str = "", **settings: float) -> RunResult:
    faults = (fault,) if fault else ()
    return run(RunRequest("follow-line", backend, "tracer", "track", seed, settings=settings, faults=faults))


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet", "virtualpi"])
@pytest.mark.parametrize("seed", [None, 1, 2])
def test_robot_follows_the_line_for_a_lap(backend: str, seed: int | None) -> None:
    result = follow(backend, seed)
    assert (result.outcome, result.verified) == (Outcome.SUCCESS, True)
    assert list(result.milestones) == ["follow"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [5, 6, 7])
def test_robot_follows_the_line_on_floors_of_other_colours(seed: int) -> None:
    request = RunRequest("follow-line", robot="tracer", world="track", seed=seed, randomise=True)
    assert run(request).verified is True


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["row noise=0.1", "row drop=0.5", "row spikes=0.05 size=0.8"])
def test_robot_follows_the_line_with_faults_of_the_sensor(fault: str) -> None:
    assert follow(fault=fault).verified is True


@pytest.mark.slow
def test_robot_finds_the_line_again_after_it_has_turned_away() -> None:
    result = follow(fault="row stuck=0 after=14 lasts=1.5")
    assert list(result.milestones) == ["follow", "search"]
    assert (result.outcome, result.verified) == (Outcome.SUCCESS, True)


def test_robot_follows_a_part_of_the_line() -> None:
    result = follow(distance_m=0.5)
    assert (result.outcome, result.verified) == (Outcome.SUCCESS, True)
    assert result.sim_time_s == pytest.approx(2.6, abs=0.2)


COURSE = """
name = "course"
[floor]
length_m = 2.4
width_m = 2.4
colour = "sand"
image = { file = "course.png", length_m = 2.0, x_m = 0.1 }
[start]
x_m = 0.1
y_m = -0.69
"""
RADIUS_M = 0.7


class Distances:
    """An observer that measures how far the robot is from the circle in the picture, in metres."""

    def begin(self, run: RunContext) -> None:
        assert run.truth
        self._truth, self.distances = run.truth, [0.0]

    def tick(self, record: TickRecord) -> None:
        pose = self._truth.pose
        self.distances.append(abs(math.hypot(pose.x - 0.1, pose.y) - RADIUS_M))

    def end(self, result: RunResult) -> None: ...


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet"])
def test_robot_follows_a_line_in_a_picture_on_the_floor(tmp_path: Path, backend: str) -> None:
    picture = np.full((500, 500, 3), 240, np.uint8)
    cv2.circle(picture, (250, 250), round(RADIUS_M * 250), (20, 20, 20), 5)
    cv2.imwrite(str(tmp_path / "course.png"), picture)
    world = tmp_path / "course.toml"
    world.write_text(COURSE)
    observer = Distances()
    result = run(RunRequest("follow-line", backend, "tracer", str(world), settings={"distance_m": 4.6}), [observer])
    assert (result.outcome, result.verified) == (Outcome.SUCCESS, None)
    assert list(result.milestones) == ["follow"]
    assert max(observer.distances) < 0.02


class Straight(Behaviour):
    """Drives straight ahead, away from the line."""

    needs: ClassVar = {Role.DRIVE}

    def step(self, robot: Robot) -> Status:
        robot.drive.set_velocity(0.3, 0.0)
        return Status.RUNNING if robot.clock.now() < 4.0 else Status.SUCCESS


def test_robot_that_leaves_the_line_is_not_verified() -> None:
    result = run(RunRequest(Straight, robot="tracer", world="track", judge="follow-line"))
    assert result.verified is False


@pytest.mark.parametrize(
    "line, verdict",
    [
        ({"max_distance": 0.02, "followed_length": 5.8, "length": 5.7}, True),
        ({"max_distance": 0.02, "followed_length": 5.6, "length": 5.7}, False),
        ({"max_distance": 0.06, "followed_length": 5.8, "length": 5.7}, False),
        ({"max_distance": 0.02, "followed_length": 6.0, "length": 50.0}, True),
        (None, None),
    ],
    ids=["lap", "less", "away", "part", "no line"],
)
def test_verify_requires_a_lap_near_the_line(line: dict[str, float] | None, verdict: bool | None) -> None:
    truth: Any = create_autospec(Truth, instance=True)
    truth.line = SimpleNamespace(**line) if line else None
    assert FollowLine().verify(truth) is verdict


def test_robot_turns_to_the_side_at_which_the_line_was() -> None:
    app = FollowLine()
    robot = MockRobot("tracer", readings={"row": [MIDDLE, LEFT, WHITE]})
    robot.run(app, ticks=8)  # the limit of the acceleration delays the turn
    straight, left, *_, search = robot.wheels
    assert straight.left == straight.right > 0
    assert left.right > left.left
    assert search.right == pytest.approx(-search.left)
    assert search.right > 0
    assert app.state == "search"


@pytest.mark.parametrize("floor, line", [(0.1, 0.9), (0.6, 0.9), (0.2, 0.5)])
def test_robot_follows_a_line_darker_than_the_floor(floor: float, line: float) -> None:
    app = FollowLine()
    seen = (floor, floor, floor, floor, line)
    robot = MockRobot("tracer", readings={"row": [(line, floor, floor, floor, floor)] + 100 * [seen]})
    robot.run(app, ticks=100)
    assert app.state == "follow"
    assert robot.wheels[-1].left > robot.wheels[-1].right


def test_even_floor_has_no_line_although_it_is_dark() -> None:
    app = FollowLine()
    MockRobot("tracer", readings={"row": [(0.75, 0.75, 0.75, 0.75, 0.75)]}).run(app, ticks=2)
    assert app.state == "search"


def test_robot_turns_back_farther_if_the_line_is_not_at_its_last_side() -> None:
    robot = MockRobot("tracer", readings={"row": [MIDDLE, LEFT, WHITE]})
    robot.run(FollowLine(), ticks=50)
    turns = [wheels.right > wheels.left for wheels in robot.wheels[8:]]
    back = turns.index(False)
    assert all(turns[:back])
    assert not any(turns[back:])
    assert len(turns) - back > back


def test_app_fails_if_the_line_stays_lost() -> None:
    app = FollowLine(search_s=1.0)
    robot = MockRobot("tracer", readings={"row": [MIDDLE, WHITE]})
    assert robot.run(app, ticks=25) is Status.FAILURE
    assert app.reason == "the line was lost for 1 s"


def test_app_that_never_sees_a_line_names_the_remedy() -> None:
    app = FollowLine(search_s=1.0)
    assert MockRobot("tracer", readings={"row": [WHITE]}).run(app, ticks=25) is Status.FAILURE
    assert app.reason == "no line was seen for 1 s. Put the robot on a line that is darker than the floor"
