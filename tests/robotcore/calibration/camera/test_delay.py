"""The delay of a camera, from synthetic turns and from the pictures of a simulated robot."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

import robotcore
from robotcore.calibration.camera.delay import (
    DelayFit,
    Heading,
    TimedPicture,
    TurnRecord,
    build_delay_chart,
    fit_delay,
    shrink,
)
from robotcore.calibration.camera.measuring import find_heading_source, record_turn
from robotcore.errors import CalibrationError
from robotcore.hal.robot import Role
from robotcore.kinds.camera import Frame
from robotcore.optics import Image, Intrinsics
from tests.texts import Raises

FOV = 1.0
WIDTH, HEIGHT = 160, 96
INTRINSICS = Intrinsics(WIDTH, HEIGHT, FOV)
TICK_S = 0.02


def turn(time: float) -> float:
    """Return the heading of a robot that turns to and fro."""
    return 0.25 * math.sin(math.tau * 0.4 * time) + 0.08 * math.sin(math.tau * 0.7 * time + 1)


def look(heading: float, panorama: Image) -> Image:
    """Return the picture of a far panorama, of which each column is a direction."""
    columns = np.arange(WIDTH, dtype=np.float32)
    bearings = heading + np.arctan2(INTRINSICS.cx - columns, INTRINSICS.focal_length)
    u = np.tile((panorama.shape[1] / 2 - bearings * 200).astype(np.float32), (HEIGHT, 1))
    v = np.tile(np.arange(HEIGHT, dtype=np.float32)[:, None], (1, WIDTH))
    return np.asarray(cv2.remap(panorama, u, v, cv2.INTER_LINEAR), np.uint8)


def draw_panorama() -> Image:
    spots = np.random.default_rng(0).integers(0, 255, (HEIGHT // 12, 50)).astype(np.uint8)
    return np.asarray(cv2.resize(spots, (600, HEIGHT), interpolation=cv2.INTER_CUBIC), np.uint8)


def record(
    *,
    age_s: float = 0.0,
    stamp_error_s: float = 0.0,
    seconds: float = 6.0,
    direction: int = 1,
    scene: Image | None = None,
) -> TurnRecord:
    """Return the record of a camera. Each picture is read ``age_s`` after its stamp, and stamped too late."""
    made, panorama = TurnRecord(), draw_panorama() if scene is None else scene
    for tick in range(round(seconds / TICK_S)):
        now = tick * TICK_S
        made.add_heading(Heading(now, turn(now)))
        stamp = now - age_s
        grey = look(direction * turn(stamp - stamp_error_s), panorama)
        made.add_frame(Frame(np.repeat(grey[..., None], 3, axis=2), stamp, tick), now)
    return made


@pytest.mark.slow
@pytest.mark.parametrize("age_s,stamp_error_s", [(0.0, 0.0), (0.12, 0.0), (0.0, 0.12), (0.04, 0.05)])
def test_a_delay_is_the_age_of_the_stamp_and_its_error(age_s: float, stamp_error_s: float) -> None:
    fit = fit_delay(record(age_s=age_s, stamp_error_s=stamp_error_s), FOV, TICK_S)
    assert fit.latency_s == pytest.approx(age_s + stamp_error_s, abs=0.004)
    assert fit.stamp_error_s == pytest.approx(stamp_error_s, abs=0.004)
    assert fit.scale == pytest.approx(1.0, abs=0.05)
    assert fit.share > 0.97


@pytest.mark.slow
def test_a_mirrored_picture_is_no_delay(raises: Raises) -> None:
    with raises(CalibrationError, "other-rotation", hide=["99%", "100%", "98%"]):
        fit_delay(record(direction=-1), FOV, TICK_S)


def test_pictures_without_details_are_refused(raises: Raises) -> None:
    with raises(CalibrationError, "too-few-details", pictures=0):
        fit_delay(record(scene=np.full((HEIGHT, 600), 128, np.uint8)), FOV, TICK_S)


def test_a_robot_that_does_not_turn_is_refused(raises: Raises) -> None:
    standing = record(seconds=3.0)
    standing.headings = [Heading(each.time, 0.0) for each in standing.headings]
    with raises(CalibrationError, "no-turn"):
        fit_delay(standing, FOV, TICK_S)


def test_a_picture_counts_once_and_few_are_stored() -> None:
    made = TurnRecord()
    frames = [Frame(np.zeros((8, 8, 3), np.uint8), number * 0.02, number) for number in range(9)]
    for frame in (*frames, frames[-1]):
        made.add_frame(frame, frame.time + 0.01)
    assert len(made.stamps) == 9
    assert [round(picture.stamp, 2) for picture in made.pictures] == [0.0, 0.08, 0.16]


def test_large_pictures_are_reduced() -> None:
    assert shrink(np.zeros((720, 1280), np.uint8)).shape == (360, 640)
    assert shrink(np.zeros((240, 320), np.uint8)).shape == (240, 320)


@pytest.mark.slow
def test_the_delay_of_a_simulated_camera_is_its_latency() -> None:
    with robotcore.open("rover", world="bench", rate_hz=50.0, needs={Role.DRIVE, Role.CAMERA}) as robot:
        made = robot.run(record_turn(robot, robot.camera, 50.0))
        assert find_heading_source(robot) == "left_encoder"
    fit = fit_delay(made, 1.0821, TICK_S)
    assert fit.latency_s == pytest.approx(0.0, abs=0.005)
    assert len(build_delay_chart(fit, "eye").series[0].xs) == len(fit.shifts_s)
    late = TurnRecord()
    late.headings, late.ages = made.headings, [0.0] * len(made.ages)
    late.stamps = [stamp + 0.1 for stamp in made.stamps]
    late.pictures = [TimedPicture(picture.grey, picture.stamp + 0.1) for picture in made.pictures]
    assert fit_delay(late, 1.0821, TICK_S).latency_s == pytest.approx(0.1, abs=0.005)


def test_the_chart_marks_the_delay_from_the_capture_and_that_of_the_stamps() -> None:
    fit = DelayFit(0.112, 0.001, 0.012, 1.0, 0.99, 50, (0.0, 0.012, 0.024), (0.02, 0.001, 0.02))
    errors, best, stamps = build_delay_chart(fit, "eye").series
    assert errors.xs == pytest.approx([0.1, 0.112, 0.124])
    assert best.xs == [0.112, 0.112]
    assert stamps.xs == pytest.approx([0.1, 0.1])


@pytest.mark.slow
def test_late_encoders_do_not_delay_the_camera() -> None:
    faults = "encoders delay=0.06"
    with robotcore.open("rover", world="bench", rate_hz=50.0, needs={Role.DRIVE, Role.CAMERA}, faults=faults) as robot:
        made = robot.run(record_turn(robot, robot.camera, 50.0))
    assert fit_delay(made, 1.0821, TICK_S).latency_s == pytest.approx(0.0, abs=0.01)
