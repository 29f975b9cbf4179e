from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.kinematic.noise import Noise
from drivers.kinematic.painter import Painter
from robotcore.devices import Camera, Encoder, Frame, Image, Range, RangeSensor
from robotcore.projection import View
from robotcore.robot import Robot
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
            assert 0 <= turned - angle < COUNT


def test_encoders_count_down_behind_zero() -> None:
    with opened() as robot:
        drive(robot, -0.0001, 0.0, 0.1)
        assert wheel_angles(robot) == pytest.approx((-COUNT, -COUNT))


def test_every_sample_of_an_instant_is_the_same_one() -> None:
    with opened(WORLD, camera_noise=3.0, range_noise_m=0.01) as robot:
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


def samples_at_half_a_second(reads_before: int, seed: int = 1) -> tuple[Range, Frame]:
    with opened(WORLD, seed=seed, camera_noise=4.0, range_noise_m=0.01) as robot:
        for _ in range(reads_before):
            let_pass(robot, 0.5 / reads_before)
            nose(robot).read()
            camera(robot).read()
        robot.clock.sleep_until(0.5)
        return nose(robot).read(), camera(robot).read()


def test_noise_depends_on_the_instant_not_on_how_often_is_read() -> None:
    (seldom, rare_frame), (often, frame) = samples_at_half_a_second(0), samples_at_half_a_second(5)
    assert seldom.distance == often.distance
    assert np.array_equal(rare_frame.image, frame.image)


def test_noise_differs_between_seeds_and_between_instants() -> None:
    one, other = samples_at_half_a_second(0, seed=1), samples_at_half_a_second(0, seed=2)
    assert one[0].distance != other[0].distance
    assert not np.array_equal(one[1].image, other[1].image)
    with opened(WORLD, range_noise_m=0.01) as robot:
        distances = set()
        for _ in range(5):
            distances.add(nose(robot).read().distance)
            let_pass(robot, 0.05)
    assert len(distances) == 5


def test_every_device_has_noise_of_its_own() -> None:
    assert Noise(1, "left", 1.0).error(5) != Noise(1, "right", 1.0).error(5)


@pytest.mark.parametrize("level", [0, 255])
def test_noise_never_wraps_around(level: int) -> None:
    grey = np.full((40, 40, 3), level, dtype=np.uint8)
    noisy = Noise(1, "eye", 8.0).over(grey, 0).astype(int)
    assert 0 < np.abs(noisy - level).max() < 60


def test_noise_is_as_strong_as_it_was_asked_for() -> None:
    with opened(WORLD) as robot:
        clean_range, clean = nose(robot).read().distance, camera(robot).read().image.astype(float)
    with opened(WORLD, camera_noise=4.0, range_noise_m=0.01) as robot:
        errors = []
        image = camera(robot).read().image
        for _ in range(400):
            errors.append(nose(robot).read().distance - clean_range)
            let_pass(robot, 0.05)
    assert np.std(errors) == pytest.approx(0.01, rel=0.15)
    assert abs(np.mean(errors)) < 0.002
    assert np.std(image - clean) == pytest.approx(4.0, rel=0.05)


def test_two_runs_are_equal_to_the_bit() -> None:
    runs = []
    for _ in range(2):
        with opened(WORLD, seed=7, camera_noise=2.0, range_noise_m=0.01) as robot:
            drive(robot, 0.2, 0.7, 1.5)
            image = camera(robot).read().image.tobytes()
            runs.append((truth_of(robot).pose(), nose(robot).read(), image))
    assert runs[0] == runs[1]
