"""Check that a rover in an existing scene moves within 1 % of the closed form.

The checks join its motors, encoders and camera, but not its nose. On a CoppeliaSim without the plug-in for proximity
sensors, the built nose is a vision sensor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from robotcore.hal.robot import Robot
from robotcore.kinds.encoder import Encoder
from tests.system import rolling
from tests.system.vrep import scenes
from tests.system.vrep.server import open_rover

JOINED = (*rolling.MOTORS, "left_encoder", "right_encoder", "eye")


@pytest.fixture(scope="module", autouse=True)
def _build_rover() -> Iterator[None]:
    with scenes.rover():
        yield


def read_angle(robot: Robot, encoder: str) -> float:
    device = robot[encoder]
    assert isinstance(device, Encoder)
    return device.read().angle


@pytest.mark.parametrize("speed", [3.0, 10.0, -6.0])
def test_straight_distance_equals_the_rolled_distance(speed: float) -> None:
    with open_rover(*rolling.MOTORS) as robot:
        rolled = rolling.drive(robot, speed, speed, rolling.metre_s(speed))
    rolling.require_straight(rolled, speed)


@pytest.mark.parametrize("speed", [2.0, -4.0])
def test_full_turn_returns_to_the_start(speed: float) -> None:
    with open_rover(*rolling.MOTORS) as robot:
        rolled = rolling.drive(robot, -speed, speed, rolling.turn_s(speed))
    rolling.require_turn(rolled, speed)


def test_encoders_count_whole_turns_and_the_picture_changes() -> None:
    speed, seconds = 4.0, 2.0
    with open_rover(*JOINED) as robot:
        first = robot.camera.read().image.astype(int)
        rolling.drive(robot, -speed, speed, seconds)
        rolled = [read_angle(robot, f"{side}_encoder") for side in ("left", "right")]
        last = robot.camera.read().image.astype(int)
    assert rolled == pytest.approx([-speed * seconds, speed * seconds], rel=0.01)
    assert abs(rolled[0]) > math.tau
    assert first.any()
    assert np.abs(last - first).max() > 50, "the ball is in front at first, and behind after half a turn"
