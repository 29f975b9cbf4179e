from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.hal.devices import Camera, Encoder, Image, RangeSensor
from robotcore.hal.robot import Robot
from robotcore.optics import View
from robotcore.simulation.painter import Painter
from tests.drivers.kinematic.rooms import ball, box, drive, let_pass, opened, room, truth_of, wheel_angles

COUNT = math.tau / 960
WORLD = room(box(1.2, 0.0, 0.2, 1.0), ball(0.9, 0.3))


def camera(robot: Robot) -> Camera:
    return robot.camera


def nose(robot: Robot) -> RangeSensor:
    return robot.range


def test_encoders_count_whole_counts_of_their_own_wheel() -> None:
    with opened() as robot:
        drive(robot, 0.2, 0.8, 1.0)
        let_pass(robot, 2.0)
        angles = wheel_angles(robot)
        true = [(0.2 + side * 0.8 * 0.155 / 2) / 0.0325 for side in (-1, 1)]
        for angle, turned in zip(angles, true, strict=True):
            assert angle / COUNT == pytest.approx(round(angle / COUNT), abs=1e-6)
            assert abs(turned - angle) <= COUNT / 2


@pytest.mark.parametrize("turned, told", [(-0.4, 0), (-0.6, -1)])
def test_encoders_tell_the_nearest_count_behind_zero_too(turned: float, told: int) -> None:
    with opened() as robot:
        drive(robot, turned * COUNT * 0.0325 / 0.1, 0.0, 0.1)
        let_pass(robot, 1.0)
        assert wheel_angles(robot) == pytest.approx((told * COUNT, told * COUNT))


def test_every_sample_of_an_instant_is_the_same_one() -> None:
    with opened(WORLD) as robot:
        encoder = robot["left_encoder"]
        assert isinstance(encoder, Encoder)
        for sensor in (camera(robot), nose(robot), encoder):
            assert sensor.read() is sensor.read()


def test_samples_are_numbered_in_the_order_they_are_taken_and_carry_their_time() -> None:
    with opened(WORLD) as robot:
        taken = []
        for _ in range(3):
            taken.append((nose(robot).read().sequence, nose(robot).read().time))
            let_pass(robot, 0.25)
    assert taken == [(0, 0.0), (1, 0.25), (2, 0.5)]


def test_a_picture_is_read_only_and_stays_what_it_was() -> None:
    with opened(WORLD) as robot:
        first = camera(robot).read()
        kept = first.image.copy()
        drive(robot, 0.0, 1.0, 0.5)
        second = camera(robot).read()
    with pytest.raises(ValueError, match="read-only"):
        first.image[0, 0] = 0
    assert np.array_equal(first.image, kept)
    assert not np.array_equal(first.image, second.image)
    assert first.image.shape == (240, 320, 3)
    assert first.image.dtype == np.uint8


def test_nothing_is_painted_unless_it_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    painted: list[View] = []
    paint = Painter.picture

    def counted(painter: Painter, view: View) -> Image:
        painted.append(view)
        return paint(painter, view)

    monkeypatch.setattr(Painter, "picture", counted)
    with opened(WORLD) as robot:
        drive(robot, 0.1, 0.0, 1.0)
        assert not painted
        camera(robot).read()
        camera(robot).read()
    assert len(painted) == 1


def test_the_camera_sees_the_ball_green_and_on_its_side() -> None:
    with opened(WORLD) as robot:
        blue, green, red = camera(robot).read().image.astype(int).transpose(2, 0, 1)
    rows, columns = np.nonzero((green > blue + 40) & (green > red + 40))
    assert len(rows) > 500
    assert columns.mean() < 150


def test_two_runs_are_equal_to_the_bit() -> None:
    runs = []
    for _ in range(2):
        with opened(WORLD) as robot:
            drive(robot, 0.2, 0.7, 1.5)
            image = camera(robot).read().image.tobytes()
            runs.append((truth_of(robot).pose(), nose(robot).read(), image))
    assert runs[0] == runs[1]
