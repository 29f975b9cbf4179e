from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from robotcore.description import Conditions
from robotcore.errors import InvalidCommandError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Frame, Image, Motor, Range
from robotcore.runtime.layers.base import MotorOutput
from robotcore.runtime.layers.imperfections import ImperfectionLayer, Noise
from tests.robotcore.fakes import EYE, ROVER, NullCamera, NullMotor, NullRange, picture

SHAPE = (24, 32, 3)
TIMES = [tick / 20 for tick in range(400)]


def test_an_instant_has_its_noise_however_often_it_is_asked_for() -> None:
    often, seldom = Noise(1, "eye", 4.0), Noise(1, "eye", 4.0)
    for time in TIMES[:10]:
        often.draw_number(time)
        often.draw_picture(SHAPE, time)
    assert often.draw_number(0.5) == seldom.draw_number(0.5)
    assert np.array_equal(often.draw_picture(SHAPE, 0.5), seldom.draw_picture(SHAPE, 0.5))


@pytest.mark.parametrize("other", [Noise(2, "eye", 4.0), Noise(1, "nose", 4.0)], ids=["seed", "device"])
def test_another_seed_or_device_has_another_noise(other: Noise) -> None:
    noise = Noise(1, "eye", 4.0)
    assert noise.draw_number(0.5) != other.draw_number(0.5)
    assert not np.array_equal(noise.draw_picture(SHAPE, 0.5), other.draw_picture(SHAPE, 0.5))


def test_every_instant_has_noise_of_its_own() -> None:
    noise = Noise(1, "eye", 4.0)
    assert len({noise.draw_number(time) for time in TIMES}) == len(TIMES)
    assert len({noise.draw_picture(SHAPE, time).tobytes() for time in TIMES}) > 0.98 * len(TIMES)


def test_numbers_err_by_the_deviation_and_not_on_average() -> None:
    noise = Noise(1, "nose", 0.01)
    errors = [noise.draw_number(time) for time in TIMES]
    assert np.std(errors) == pytest.approx(0.01, rel=0.15)
    assert abs(np.mean(errors)) < 0.002


@pytest.mark.parametrize("sigma", [0.1, 0.2, 0.5, 1.0, 4.0, 64.0])
def test_a_picture_errs_by_the_deviation_however_small(sigma: float) -> None:
    picture = Noise(1, "eye", sigma).draw_picture((480, 640, 3), 0.5).astype(float)
    assert np.std(picture) == pytest.approx(sigma, rel=0.02)
    assert abs(picture.mean()) < sigma / 100


def test_every_pixel_of_a_picture_errs_by_itself() -> None:
    picture = Noise(1, "eye", 4.0).draw_picture((240, 320, 3), 0.5).astype(float)
    assert abs((picture[:, 1:] * picture[:, :-1]).mean()) < 0.3


def test_one_pixel_errs_by_the_deviation_from_instant_to_instant() -> None:
    noise = Noise(1, "eye", 4.0)
    errors = [noise.draw_picture(SHAPE, time)[3, 4, 1] for time in TIMES]
    assert np.std(errors) == pytest.approx(4.0, rel=0.15)


def test_noise_is_what_it_was_when_this_was_written() -> None:
    noise = Noise(1, "eye", 4.0)
    assert noise.draw_number(0.5) == pytest.approx(3.195127317405856)
    assert noise.draw_picture(SHAPE, 0.5)[0, :2].tolist() == [[2, 4, 0], [2, -5, -4]]


DRIVE = ROVER.drive


def clock() -> SteppedClock:
    return SteppedClock(20, lambda _: None)


def seen(image: Image, seed: int = 1, **conditions: float) -> Image:
    """Return what becomes of a picture."""
    camera = NullCamera(clock())
    camera.image = image
    frame: Frame = ImperfectionLayer(Conditions(**conditions), seed, DRIVE).sensor(camera, camera.read)()
    return frame.image


def heard(distance: float, seed: int = 1, **conditions: float) -> Range:
    sensor = NullRange(clock(), distance=distance)
    reading: Range = ImperfectionLayer(Conditions(**conditions), seed, DRIVE).sensor(sensor, sensor.read)()
    return reading


class TestCamera:
    def test_where_it_is_perfect_it_is_the_drivers_own(self) -> None:
        camera = NullCamera(clock())
        others = ImperfectionLayer(Conditions(range_noise_m=0.1, wheel_gain_left=0.9), 1, DRIVE)
        assert others.sensor(camera, camera.read) == camera.read

    def test_time_and_number_stay_and_the_picture_is_read_only(self) -> None:
        camera = NullCamera(clock())
        layer = ImperfectionLayer(Conditions(camera_noise=3.0, camera_blur_px=1.0), 1, DRIVE)
        frame = layer.sensor(camera, camera.read)()
        assert (frame.time, frame.sequence) == (0.0, 1)
        assert frame.image.shape == (EYE.height, EYE.width, 3)
        assert frame.image.dtype == np.uint8
        assert not frame.image.flags.writeable
        assert camera.image.max() == 0

    def test_exposure_takes_more_or_less_light_and_ends_at_white(self) -> None:
        assert seen(picture((10, 100, 200)), camera_exposure=1.5)[0, 0].tolist() == [15, 150, 255]
        assert seen(picture((10, 100, 200)), camera_exposure=0.5)[0, 0].tolist() == [5, 50, 100]

    def test_warmth_turns_blue_into_red_and_cold_red_into_blue(self) -> None:
        assert seen(picture((100, 100, 100)), camera_warmth=0.2)[0, 0].tolist() == [80, 100, 120]
        assert seen(picture((100, 100, 100)), camera_warmth=-0.2)[0, 0].tolist() == [120, 100, 80]

    def test_blur_spreads_a_point_and_keeps_its_light(self) -> None:
        point = np.zeros((EYE.height, EYE.width, 3), dtype=np.uint8)
        point[12, 16] = 250
        blurred = seen(point, camera_blur_px=1.0)
        assert blurred[12, 16, 0] < 50 < blurred[11:14, 15:18, 0].sum()
        assert blurred[:, :, 0].sum() == pytest.approx(250, rel=0.1)

    @pytest.mark.parametrize("level", [0, 255])
    def test_noise_never_wraps_around(self, level: int) -> None:
        noisy = seen(picture((level, level, level)), camera_noise=8.0).astype(int)
        assert 0 < np.abs(noisy - level).max() < 60

    def test_noise_comes_after_exposure_and_exposure_after_blur(self) -> None:
        half = picture((0, 0, 0)).copy()
        half[:, 16:] = 250
        every = seen(half, camera_blur_px=2.0, camera_exposure=2.0, camera_noise=2.0).astype(int)
        bright = np.minimum(2 * cv2.GaussianBlur(half, (0, 0), 2.0).astype(int), 255)
        noise = seen(picture((128, 128, 128)), camera_noise=2.0).astype(int) - 128
        assert np.abs(every - np.clip(bright + noise, 0, 255)).max() == 0

    def test_another_seed_has_another_noise(self) -> None:
        grey = picture((128, 128, 128))
        one, again, other = (seen(grey, seed, camera_noise=3.0) for seed in (1, 1, 2))
        assert np.array_equal(one, again)
        assert not np.array_equal(one, other)


class TestRange:
    def test_where_it_is_perfect_it_is_the_drivers_own(self) -> None:
        sensor = NullRange(clock())
        others = ImperfectionLayer(Conditions(camera_noise=3.0), 1, DRIVE)
        assert others.sensor(sensor, sensor.read) == sensor.read

    def test_a_bias_moves_every_distance(self) -> None:
        assert heard(1.0, range_bias_m=0.05).distance == pytest.approx(1.05)
        assert heard(1.0, range_bias_m=-0.05).distance == pytest.approx(0.95)

    def test_noise_is_another_at_every_seed(self) -> None:
        distances = {heard(1.0, seed, range_noise_m=0.01).distance for seed in range(20)}
        assert len(distances) == 20
        assert max(abs(distance - 1.0) for distance in distances) < 0.05

    def test_nothing_in_range_stays_inf_and_what_errs_out_of_range_is_inf_too(self) -> None:
        assert math.isinf(heard(math.inf, range_noise_m=0.1, range_bias_m=-0.5).distance)
        assert math.isinf(heard(1.99, range_bias_m=0.02).distance)

    def test_it_is_never_nearer_than_the_sensor_can_tell(self) -> None:
        assert heard(0.03, range_bias_m=-0.5).distance == 0.02

    def test_the_point_stays_where_it_is_and_goes_where_nothing_is_heard(self) -> None:
        sensor = NullRange(clock())
        for bias, point in ((0.1, (1.0, 0.0, 0.0)), (1.0, None)):
            read = ImperfectionLayer(Conditions(range_bias_m=bias), 1, DRIVE).sensor(sensor, sensor.read)
            sensor._newest = lambda: Range(1.5, 0.0, 4, (1.0, 0.0, 0.0))  # type: ignore[method-assign]
            assert (read().point, read().sequence) == (point, 4)


def gained(motor: Motor, gain: float) -> MotorOutput:
    return ImperfectionLayer(Conditions(wheel_gain_left=gain), 1, DRIVE).motor(MotorOutput.of(motor))


class TestMotor:
    def test_where_it_is_perfect_it_is_the_drivers_own(self) -> None:
        output = MotorOutput.of(NullMotor("left_motor"))
        assert ImperfectionLayer(Conditions(wheel_gain_left=1.0), 1, DRIVE).motor(output) is output

    def test_only_the_drives_wheels_have_gains(self) -> None:
        arm = NullMotor("arm")
        gained(arm, 0.9).set_velocity(5.0)
        assert arm.sent == [5.0]

    def test_the_wheel_turns_gain_times_as_fast_and_the_robot_does_not_know(self) -> None:
        motor = NullMotor("left_motor")
        assert gained(motor, 0.9).set_velocity(5.0) == 5.0
        assert motor.sent == [4.5]

    def test_the_motors_limit_holds(self) -> None:
        motor = NullMotor("left_motor", 12.0)
        gained(motor, 1.07).set_velocity(12.0)
        assert motor.sent == [12.0]

    def test_a_stop_is_a_stop_and_what_is_no_number_too(self) -> None:
        motor = NullMotor("left_motor")
        wheel = gained(motor, 0.9)
        wheel.stop()
        with pytest.raises(InvalidCommandError):
            wheel.set_velocity(math.nan)
        assert motor.sent == [0.0, 0.0]
