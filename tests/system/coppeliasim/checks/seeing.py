"""Compare pictures and distances with the geometry of the world."""

from __future__ import annotations

import numpy as np
import pytest

from robotcore.description import load_robot
from robotcore.geometry import Pose
from robotcore.hal.robot import Role
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.optics import CameraView
from robotcore.testing import worlds
from tests.system.coppeliasim.server import open_robot

ROVER = load_robot("rover")


@pytest.mark.parametrize("distance", [0.05, 0.25, 1.0, 1.9])
def test_distance_to_a_wall_is_within_1_cm(distance: float) -> None:
    nose = ROVER.first_of(RangeSensorDescription)
    assert nose
    with open_robot(worlds.wall(nose.mount, distance), nose.name) as robot:
        assert robot.range.read().distance == pytest.approx(distance, abs=0.01)


@pytest.mark.parametrize("size", [(320, 240), (160, 160), (120, 240)])
def test_field_of_view_is_horizontal_for_each_shape_of_picture(size: tuple[int, int]) -> None:
    eye = ROVER.first_of(CameraDescription)
    assert eye
    changed = eye.model_copy(update={"width_px": size[0], "height_px": size[1]})
    devices = tuple(changed if device is eye else device for device in ROVER.devices)
    world = worlds.ball(eye.mount, 0.9, 0.25 * eye.horizontal_fov_rad)
    ball = world.targets[0]
    view = CameraView.of(changed.intrinsics, eye.mount, Pose(0.0, 0.0, 0.0))
    column, row = view.to_pixels(view.to_camera(np.array([[ball.x_m, ball.y_m, ball.radius_m]])))[0]
    with open_robot(world, eye.name, robot=ROVER.model_copy(update={"devices": devices})) as robot:
        blue, green, red = robot.camera.read().image.astype(int).transpose(2, 0, 1)
    rows, columns = np.nonzero(green > np.maximum(blue, red) + 25)
    assert columns.mean() == pytest.approx(column, abs=2)
    assert rows.mean() == pytest.approx(row, abs=2)


def test_first_samples_show_the_world_before_any_motion() -> None:
    eye = ROVER.first_of(CameraDescription)
    assert eye
    with open_robot(worlds.ball(eye.mount, 0.5, 0.0)) as robot:
        assert robot.clock.now() == 0
        assert robot.camera.read().image.any()
        assert robot.has(Role.RANGE)
        assert robot.range.read().distance == pytest.approx(0.4, abs=0.01)
