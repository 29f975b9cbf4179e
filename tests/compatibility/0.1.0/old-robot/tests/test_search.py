"""Test the decisions of the app with scripted sensor samples."""

from pathlib import Path

import cv2
import numpy as np
from robotcore import Image, Status
from robotcore.testing import MockRobot

from search import Search

ROBOT = str(Path(__file__).parents[1] / "old_robot.toml")
GREEN_BGR = (40, 160, 40)


def picture(ball_at: int) -> Image:
    """Return a grey picture with a green ball at the column ``ball_at``."""
    image = np.full((240, 320, 3), 128, np.uint8)
    cv2.circle(image, (ball_at, 120), 20, GREEN_BGR, -1)
    return image


def test_steers_left_to_a_ball_on_the_left() -> None:
    robot = MockRobot(ROBOT, camera=picture(ball_at=80), range=1.0)
    robot.run(Search(), ticks=3)
    left, right = robot.wheels[-1]
    assert left < right


def test_stops_in_front_of_the_ball() -> None:
    robot = MockRobot(ROBOT, camera=picture(ball_at=160), range=[0.5, 0.4, 0.27])
    assert robot.run(Search(), ticks=40) is Status.SUCCESS
    assert robot.wheels[0].left > 0
    assert robot.wheels[-1] == (0.0, 0.0)


def test_gives_up_without_a_ball() -> None:
    app = Search(hue="blue")
    robot = MockRobot(ROBOT, camera=picture(ball_at=160))
    assert robot.run(app, ticks=200) is Status.FAILURE
    assert "nothing blue" in app.reason
