from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from robotcore.description import Conditions
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Frame, Image, Motor, Range
from robotcore.runtime.layers.base import MotorOutput
from robotcore.runtime.layers.imperfections import ImperfectionLayer, Noise
from tests.robotcore.fakes import EYE, ROVER, NullCamera, NullMotor, NullRange, picture

SHAPE = (24, 32, 3)
TIMES = [tick / 20 for tick in range(400)]


@pytest.mark.parametrize("other", [Noise(2, "eye", 4.0), Noise(1, "nose", 4.0)], ids=["seed", "device"])
def test_noise_depends_on_seed_and_device(other: Noise) -> None:
    noise = Noise(1, "eye", 4.0)
    assert noise.draw_number(0.5) != other.draw_number(0.5)
    assert not np.array_equal(noise.draw_picture(SHAPE, 0.5), other.draw_picture(SHAPE, 0.5))


def test_numbers_have_the_deviation_and_no_bias() -> None:
    noise = Noise(1, "nose", 0.01)
    errors = [noise.draw_number(time) for time in TIMES]
    assert np.std(errors) == pytest.approx(0.01, rel=0.15)
    assert abs(np.mean(errors)) < 0.002


@pytest.mark.parametrize("sigma", [0.1, 0.2, 0.5, 1.0, 4.0, 64.0])
def test_picture_has_the_deviation_even_if_it_is_small(sigma: float) -> None:
    picture = Noise(1, "eye", sigma).draw_picture((480, 640, 3), 0.5).astype(float)
    assert np.std(picture) == pytest.approx(sigma, rel=0.02)
    assert abs(picture.mean()) < sigma / 100


def test_noise_equals_the_stored_values() -> None:
    noise = Noise(1, "eye", 4.0)
    assert noise.draw_number(0.5) == pytest.approx(3.195127317405856)
    assert noise.draw_picture(SHAPE, 0.5)[0, :2].tolist() == [[2, 4, 0], [2, -5, -4]]


DRIVE = ROVER.drive


def clock() -> SteppedClock:
    return SteppedClock(20, lambda _: None)


def process_picture(image: Image, seed: int = 1, **conditions: float) -> Image:
    """Return a picture with the imperfections of these conditions."""
    camera = NullCamera(clock())
    camera.image = image
    frame: Frame = ImperfectionLayer(Conditions(**conditions), seed, DRIVE).sensor(camera, camera.read)()
    return frame.image


def read_distance(distance: float, seed: int = 1, **conditions: float) -> Range:
    sensor = NullRange(clock(), distance=distance)
    reading: Range = ImperfectionLayer(Conditions(**conditions), seed, DRIVE).sensor(sensor, sensor.read)()
    return reading


class TestCamera:
    def test_device_without_imperfections_is_not_wrapped(self) -> None:
        camera = NullCamera(clock())
        others = ImperfectionLayer(Conditions(range_noise_m=0.1, wheel_gain_left=0.9), 1, DRIVE)
        assert others.sensor(camera, camera.read) == camera.read

    def test_processed_frame_keeps_time_and_sequence_and_is_read_only(self) -> None:
        camera = NullCamera(clock())
        layer = ImperfectionLayer(Conditions(camera_noise=3.0, camera_blur_px=1.0), 1, DRIVE)
        frame = layer.sensor(camera, camera.read)()
        assert (frame.time, frame.sequence) == (0.0, 1)
        assert frame.image.shape == (EYE.height, EYE.width, 3)
        assert frame.image.dtype == np.uint8
        assert not frame.image.flags.writeable
        assert camera.image.max() == 0

    def test_exposure_multiplies_values_up_to_white(self) -> None:
        assert process_picture(picture((10, 100, 200)), camera_exposure=1.5)[0, 0].tolist() == [15, 150, 255]
        assert process_picture(picture((10, 100, 200)), camera_exposure=0.5)[0, 0].tolist() == [5, 50, 100]

    def test_warmth_raises_red_and_lowers_blue(self) -> None:
        assert process_picture(picture((100, 100, 100)), camera_warmth=0.2)[0, 0].tolist() == [80, 100, 120]
        assert process_picture(picture((100, 100, 100)), camera_warmth=-0.2)[0, 0].tolist() == [120, 100, 80]

    def test_blur_spreads_a_point_and_keeps_its_sum(self) -> None:
        point = np.zeros((EYE.height, EYE.width, 3), dtype=np.uint8)
        point[12, 16] = 250
        blurred = process_picture(point, camera_blur_px=1.0)
        assert blurred[12, 16, 0] < 50 < blurred[11:14, 15:18, 0].sum()
        assert blurred[:, :, 0].sum() == pytest.approx(250, rel=0.1)

    @pytest.mark.parametrize("level", [0, 255])
    def test_noise_does_not_wrap_around(self, level: int) -> None:
        noisy = process_picture(picture((level, level, level)), camera_noise=8.0).astype(int)
        assert 0 < np.abs(noisy - level).max() < 60

    def test_effects_are_blur_exposure_and_noise_in_this_order(self) -> None:
        half = picture((0, 0, 0)).copy()
        half[:, 16:] = 250
        every = process_picture(half, camera_blur_px=2.0, camera_exposure=2.0, camera_noise=2.0).astype(int)
        bright = np.minimum(2 * cv2.GaussianBlur(half, (0, 0), 2.0).astype(int), 255)
        noise = process_picture(picture((128, 128, 128)), camera_noise=2.0).astype(int) - 128
        assert np.abs(every - np.clip(bright + noise, 0, 255)).max() == 0


class TestRange:
    def test_bias_is_added_to_every_distance(self) -> None:
        assert read_distance(1.0, range_bias_m=0.05).distance == pytest.approx(1.05)
        assert read_distance(1.0, range_bias_m=-0.05).distance == pytest.approx(0.95)

    def test_distances_beyond_the_range_are_infinite(self) -> None:
        assert math.isinf(read_distance(math.inf, range_noise_m=0.1, range_bias_m=-0.5).distance)
        assert math.isinf(read_distance(1.99, range_bias_m=0.02).distance)

    def test_point_is_kept_and_is_none_beyond_the_range(self) -> None:
        sensor = NullRange(clock())
        for bias, point in ((0.1, (1.0, 0.0, 0.0)), (1.0, None)):
            read = ImperfectionLayer(Conditions(range_bias_m=bias), 1, DRIVE).sensor(sensor, sensor.read)
            sensor._newest = lambda: Range(1.5, 0.0, 4, (1.0, 0.0, 0.0))  # type: ignore[method-assign]
            assert (read().point, read().sequence) == (point, 4)


def add_gain(motor: Motor, gain: float) -> MotorOutput:
    return ImperfectionLayer(Conditions(wheel_gain_left=gain), 1, DRIVE).motor(MotorOutput.of(motor))


class TestMotor:
    def test_gains_apply_only_to_wheels_of_the_drive(self) -> None:
        arm = NullMotor("arm")
        add_gain(arm, 0.9).set_velocity(5.0)
        assert arm.sent == [5.0]

    def test_gain_multiplies_the_velocity_but_not_the_return_value(self) -> None:
        motor = NullMotor("left_motor")
        assert add_gain(motor, 0.9).set_velocity(5.0) == 5.0
        assert motor.sent == [4.5]
