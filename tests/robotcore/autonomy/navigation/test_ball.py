from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.autonomy.navigation import BallTracker
from robotcore.geometry import Pose
from robotcore.kinds.camera import Frame
from robotcore.optics import Image
from tests.robotcore.fakes import EYE, Rig, picture

RADIUS = 0.1
GREEN = (60, 170, 40)
POSE = Pose(1.0, -2.0, math.pi / 2)
"""The robot's pose. Its camera and its range sensor are 0.14 m ahead of the axle."""


@pytest.fixture
def rig() -> Rig:
    return Rig()


@pytest.fixture
def tracker() -> BallTracker:
    return BallTracker("green", RADIUS)


def ball(left: int, top: int, size: int) -> Image:
    """Return a picture of a green square."""
    image = picture().copy()
    image[top : top + size, left : left + size] = GREEN
    return image


def measure_place(tracker: BallTracker) -> tuple[float, float]:
    """Return the distance of the tracker's ball from the camera in metres, and its bearing in radians."""
    assert tracker.place
    eye = POSE.compose(Pose(0.14, 0.0, 0.0))
    return eye.distance_to(*tracker.place), eye.bearing_to(*tracker.place)


def test_time_without_the_ball_is_counted(rig: Rig, tracker: BallTracker) -> None:
    for passed in (0.0, 0.05, 0.1):
        assert tracker.look(rig.robot, POSE) is None
        assert tracker.lost_for == pytest.approx(passed)
        rig.sleep(0.05)
    assert tracker.place is None
    assert not tracker.is_in_sight


def test_place_follows_from_size_and_column(rig: Rig, tracker: BallTracker) -> None:
    rig.eye.image = ball(4, 8, 6)
    blob = tracker.look(rig.robot, POSE)
    assert blob
    assert measure_place(tracker) == pytest.approx((RADIUS * EYE.focal_length / 3, EYE.bearing(6.5)))
    assert tracker.lost_for == 0


@pytest.mark.parametrize(
    "left, error, is_used",
    [(13, 0.1, True), (13, -0.1, True), (13, 0.2, False), (13, -0.2, False), pytest.param(1, 0.1, False, id="aside")],
)
def test_echo_in_the_cone_that_agrees_with_the_size_gives_the_distance(
    rig: Rig, tracker: BallTracker, left: int, error: float, is_used: bool
) -> None:
    rig.eye.image = ball(left, 8, 6)
    by_size = RADIUS * EYE.focal_length / 3
    rig.nose.distance = by_size - RADIUS + error
    tracker.look(rig.robot, POSE)
    assert measure_place(tracker)[0] == pytest.approx(by_size + error if is_used else by_size)


@pytest.mark.parametrize("x, y", [(0.02, 0.0), (0.2, 0.0), (0.14, 0.05), (0.04, -0.05)])
def test_echo_is_measured_from_the_range_sensor(rig: Rig, tracker: BallTracker, x: float, y: float) -> None:
    rig.robot.camera.mount = Pose(x, y, 0.0)
    rig.eye.image = ball(13, 8, 6)
    rig.nose.distance = RADIUS * EYE.focal_length / 3 - RADIUS
    tracker.look(rig.robot, POSE)
    assert tracker.place
    sensor, eye = POSE.compose(Pose(0.14, 0.0, 0.0)), POSE.compose(Pose(x, y, 0.0))
    assert sensor.distance_to(*tracker.place) == pytest.approx(rig.nose.distance + RADIUS)
    assert eye.bearing_to(*tracker.place) == pytest.approx(EYE.bearing(15.5))


def test_turned_camera_uses_no_echo_from_ahead(rig: Rig, tracker: BallTracker) -> None:
    rig.robot.camera.mount = Pose(0.14, 0.0, 1.0)
    rig.eye.image = ball(13, 8, 6)
    by_size = RADIUS * EYE.focal_length / 3
    rig.nose.distance = by_size - RADIUS + 0.1
    tracker.look(rig.robot, POSE)
    assert measure_place(tracker) == pytest.approx((by_size, 1.0 + EYE.bearing(15.5)))


def test_late_picture_is_used_with_the_mount_at_its_time(rig: Rig, tracker: BallTracker) -> None:
    rig.robot.camera.mount = Pose(0.14, 0.0, 1.0)
    tracker.look(rig.robot, POSE)
    rig.eye._newest = lambda: Frame(ball(13, 8, 6), 0.0, 0)  # type: ignore[method-assign]
    rig.sleep(0.1)
    rig.robot.camera.mount = Pose(0.14, 0.0, -1.0)
    tracker.look(rig.robot, POSE)
    assert measure_place(tracker)[1] == pytest.approx(1.0 + EYE.bearing(15.5))


def test_echo_gives_the_distance_if_the_ball_fills_the_picture(rig: Rig, tracker: BallTracker) -> None:
    rig.eye.image = picture(GREEN)
    rig.nose.distance = 0.5
    tracker.look(rig.robot, POSE)
    assert measure_place(tracker)[0] == pytest.approx(0.6)


def test_small_blob_does_not_change_a_measured_place(rig: Rig, tracker: BallTracker) -> None:
    rig.eye.image = ball(13, 8, 6)
    tracker.look(rig.robot, POSE)
    seen_well = tracker.place
    rig.sleep(0.05)
    rig.eye.image = ball(2, 2, 4)
    assert tracker.look(rig.robot, POSE)
    assert tracker.place == seen_well
    assert not tracker.is_in_sight
    tracker.forget()
    tracker.look(rig.robot, POSE)
    assert tracker.place not in {seen_well, None}


def test_picture_with_a_box_is_shown(rig: Rig, tracker: BallTracker) -> None:
    rig.eye.image = ball(13, 8, 6)
    tracker.look(rig.robot, POSE)
    assert rig.screen.picture is not None
    assert np.any(np.all(rig.screen.picture == (0, 255, 255), axis=2))


def test_a_robot_without_a_display_can_track_too(tracker: BallTracker) -> None:
    rig = Rig(names=("nose", "eye"))
    assert tracker.look(rig.robot, POSE) is None


def test_late_picture_is_used_with_the_pose_at_its_time(rig: Rig, tracker: BallTracker) -> None:
    tracker.look(rig.robot, POSE)
    rig.sleep(0.1)
    rig.eye._newest = lambda: Frame(ball(4, 8, 6), 0.0, 1)  # type: ignore[method-assign]
    tracker.look(rig.robot, Pose(3.0, 3.0, 0.0))
    assert measure_place(tracker) == pytest.approx((RADIUS * EYE.focal_length / 3, EYE.bearing(6.5)))


def test_watch_looks_once_in_each_tick(rig: Rig, tracker: BallTracker) -> None:
    watching = tracker.watch(rig.robot)
    next(watching)
    assert not tracker.is_in_sight
    rig.eye.image = ball(4, 8, 6)
    assert not tracker.is_in_sight
    rig.sleep(0.05)
    next(watching)
    assert tracker.is_in_sight


def test_forgotten_ball_is_not_in_sight_before_the_next_picture(rig: Rig, tracker: BallTracker) -> None:
    rig.eye.image = ball(4, 8, 6)
    tracker.look(rig.robot, POSE)
    tracker.forget()
    assert (tracker.is_in_sight, tracker.place) == (False, None)
    tracker.look(rig.robot, POSE)
    assert tracker.is_in_sight
    assert tracker.place
