"""The rover that is joined rolls as it is told: against the closed form, within a hundredth.

Its motors, encoders and camera are joined, and its nose is not: built on a CoppeliaSim without the plug-in for
proximity sensors it is a vision sensor.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from robotcore.hal.devices import Encoder
from robotcore.hal.robot import Robot
from tests.system import rolling
from tests.system.vrep import scenes
from tests.system.vrep.server import opened

JOINED = (*rolling.MOTORS, "left_encoder", "right_encoder", "eye")


@pytest.fixture(scope="module", autouse=True)
def _built() -> Iterator[None]:
    with scenes.rover():
        yield


def angle(robot: Robot, encoder: str) -> float:
    device = robot[encoder]
    assert isinstance(device, Encoder)
    return device.read().angle


@pytest.mark.parametrize("speed", [3.0, 10.0, -6.0])
def test_straight_ahead_goes_as_far_as_the_wheels_roll(speed: float) -> None:
    with opened(*rolling.MOTORS) as robot:
        rolled = rolling.driven(robot, speed, speed, rolling.metre_s(speed))
    rolling.require_straight(rolled, speed)


@pytest.mark.parametrize("speed", [2.0, -4.0])
def test_whole_turn_comes_back(speed: float) -> None:
    with opened(*rolling.MOTORS) as robot:
        rolled = rolling.driven(robot, -speed, speed, rolling.turn_s(speed))
    rolling.require_turn(rolled, speed)


def test_encoders_count_whole_turns_and_the_camera_sees_itself_turn() -> None:
    speed, seconds = 4.0, 2.0
    with opened(*JOINED) as robot:
        first = robot.camera.read().image.astype(int)
        rolling.driven(robot, -speed, speed, seconds)
        rolled = [angle(robot, f"{side}_encoder") for side in ("left", "right")]
        last = robot.camera.read().image.astype(int)
    assert rolled == pytest.approx([-speed * seconds, speed * seconds], rel=0.01)
    assert abs(rolled[0]) > math.tau
    assert first.any()
    assert np.abs(last - first).max() > 50, "the ball is ahead at first, and behind it after half a turn"
