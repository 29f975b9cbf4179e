"""The app searches with a camera that a servo pans, and keeps the camera on the ball while the robot drives to it."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from apps.pan_search import PanSearch
from robotcore import Outcome, RunRequest, run
from robotcore.optics import Image
from robotcore.testing import MockRobot


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet", "virtualpi"])
@pytest.mark.parametrize("world", ["open", "arena"])
def test_robot_finds_the_ball(backend: str, world: str) -> None:
    result = run(RunRequest("pan-search", robot="scout", world=world, backend=backend))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason
    assert list(result.milestones)[-2:] == ["approach", "arrived"]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 3, 5])
def test_robot_finds_the_ball_with_pictures_that_are_late(seed: int) -> None:
    """A late picture counts with the angle that the servo had when it was taken."""
    result = run(RunRequest("pan-search", robot="scout", world="open", seed=seed, faults=("camera delay=0.15",)))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
@pytest.mark.parametrize("seed", [12, 22])
def test_robot_faces_a_ball_behind_obstacles(seed: int) -> None:
    """In these worlds, the robot has to look from elsewhere, and comes near the ball from the side."""
    result = run(RunRequest("pan-search", robot="scout", world="clutter", seed=seed))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason


@pytest.mark.slow
@pytest.mark.parametrize("world, seed", [("arena", 3), ("clutter", 7)])
def test_range_sensor_on_the_servo_of_the_camera_looks_ahead_while_the_robot_drives(world: str, seed: int) -> None:
    result = run(RunRequest("pan-search", robot="freenove-4wd", world=world, seed=seed))
    assert (result.outcome, result.verified, result.contacts) == (Outcome.SUCCESS, True, 0), result.reason
    assert result.intervention_s.get("range guard", 0.0) < 2.0


def ball_at(column: int) -> Image:
    picture = np.full((240, 320, 3), 128, np.uint8)
    cv2.circle(picture, (column, 120), 20, (40, 160, 40), -1)
    return picture


@pytest.mark.parametrize("column, side", [(80, 1), (240, -1)])
def test_camera_turns_to_the_ball(column: int, side: int) -> None:
    robot = MockRobot("scout", camera=ball_at(column), range=1.0)
    robot.run(PanSearch(), ticks=1)
    focal_length = 160 / math.tan(1.0821 / 2)
    assert robot.commands["pan"][-1].value == pytest.approx(side * math.atan(80 / focal_length), abs=0.05)


def test_camera_pans_from_one_limit_to_the_other_until_the_ball_is_seen() -> None:
    robot = MockRobot("scout", range=1.0)
    robot.run(PanSearch(), ticks=90)
    angles = [command.value for command in robot.commands["pan"]]
    assert (min(angles), max(angles)) == (-1.57, 1.57)
    assert abs(np.diff(angles)).max() == pytest.approx(1.5 / 20)
