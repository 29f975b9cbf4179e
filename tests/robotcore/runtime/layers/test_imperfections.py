from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from robotcore.description import Conditions, load_robot
from robotcore.hal.clock import SteppedClock
from robotcore.hal.noise import Noise
from robotcore.kinds.camera import Frame
from robotcore.kinds.range_sensor import Range
from robotcore.optics import Image
from robotcore.runtime.layers.base import MotorOutput
from robotcore.runtime.layers.imperfections import ImperfectionLayer
from tests.robotcore.fakes import EYE, ROVER, NullCamera, NullMotor, NullRange, picture

SHAPE = (24, 32, 3)


@pytest.mark.parametrize("other", [Noise(2, "eye", 4.0), Noise(1, "nose", 4.0)], ids=["seed", "device"])
def test_noise_depends_on_seed_and_device(other: Noise) -> None:
    noise = Noise(1, "eye", 4.0)
    assert noise.draw_number(0.5) != other.draw_number(0.5)
    assert not np.array_equal(noise.draw_picture(SHAPE, 0.5), other.draw_picture(SHAPE, 0.5))


@pytest.mark.parametrize("sigma", [0.1, 1.0, 64.0])
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


def process_picture(image: Image, **conditions: float) -> Image:
    """Return a picture with the imperfections of these conditions."""
    camera = NullCamera(clock())
    camera.image = image
    frame: Frame = ImperfectionLayer(Conditions(**conditions), 1, DRIVE).sensor(camera, camera.read)()
    return frame.image


def read_distance(distance: float, **conditions: float) -> Range:
    sensor = NullRange(clock(), distance=distance)
    reading: Range = ImperfectionLayer(Conditions(**conditions), 1, DRIVE).sensor(sensor, sensor.read)()
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

    @pytest.mark.parametrize(
        "conditions, colour",
        [
            ({"camera_exposure": 2.0}, [20, 200, 255]),
            ({"camera_warmth": 0.2}, [8, 100, 240]),
            ({"camera_warmth": -0.2}, [12, 100, 160]),
        ],
    )
    def test_exposure_and_warmth_change_the_colours(self, conditions: dict[str, float], colour: list[int]) -> None:
        assert process_picture(picture((10, 100, 200)), **conditions)[0, 0].tolist() == colour

    def test_blur_spreads_a_bright_pixel_evenly(self) -> None:
        image = picture((0, 0, 0)).copy()
        image[10, 12] = 255
        blurred = process_picture(image, camera_blur_px=1.0)[7:14, 9:16, 0]
        assert 0 < blurred[3, 2] == blurred[3, 4] == blurred[2, 3] == blurred[4, 3] < blurred[3, 3] < 255
        assert blurred.sum() == pytest.approx(255, abs=15)

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


@pytest.mark.parametrize(
    "distance, conditions, read",
    [
        (1.0, {"range_bias_m": -0.05}, 0.95),
        (math.inf, {"range_noise_m": 0.1, "range_bias_m": -0.5}, math.inf),
        (1.99, {"range_bias_m": 0.02}, math.inf),
    ],
)
def test_bias_is_added_and_a_distance_beyond_the_range_is_infinite(
    distance: float, conditions: dict[str, float], read: float
) -> None:
    assert read_distance(distance, **conditions).distance == pytest.approx(read)


def test_point_is_kept_and_is_none_beyond_the_range() -> None:
    sensor = NullRange(clock())
    for bias, point in ((0.1, (1.0, 0.0, 0.0)), (1.0, None)):
        read = ImperfectionLayer(Conditions(range_bias_m=bias), 1, DRIVE).sensor(sensor, sensor.read)
        sensor._newest = lambda: Range(1.5, 0.0, 4, (1.0, 0.0, 0.0))  # type: ignore[method-assign]
        assert (read().point, read().sequence) == (point, 4)


@pytest.mark.parametrize("name, sent", [("left_motor", 4.5), ("arm", 5.0)])
def test_gain_changes_the_velocity_of_a_wheel_but_not_the_return_value(name: str, sent: float) -> None:
    motor = NullMotor(name)
    output = ImperfectionLayer(Conditions(wheel_gain_left=0.9), 1, DRIVE).motor(MotorOutput.from_motor(motor))
    assert output.set_velocity(5.0) == 5.0
    assert motor.sent == [sent]


def test_motor_with_a_differential_gear_has_the_mean_gain() -> None:
    picar = load_robot("picar").drive
    assert picar
    names = dict.fromkeys(("left", "right", "left_encoder", "right_encoder"))
    motor, drive = NullMotor("engine"), picar.model_copy(update={**names, "motor": "engine"})
    conditions = Conditions(wheel_gain_left=0.8, wheel_gain_right=1.0)
    ImperfectionLayer(conditions, 1, drive).motor(MotorOutput.from_motor(motor)).set_velocity(5.0)
    assert motor.sent == [pytest.approx(4.5)]


def test_robot_without_a_drive_has_motors_without_imperfections() -> None:
    motor = MotorOutput.from_motor(NullMotor("arm"))
    assert ImperfectionLayer(Conditions(wheel_gain_left=0.5), 1, None).motor(motor) == motor
