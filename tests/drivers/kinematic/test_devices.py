"""Devices of the built-in simulator, and the fan of rays of its range sensors."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.kinematic.devices import Sonar
from robotcore.description import Mount, WorldDescription
from robotcore.geometry import Pose
from robotcore.hal.robot import Robot
from robotcore.kinds.camera import Camera
from robotcore.kinds.range_sensor import RangeSensor, RangeSensorDescription
from tests.drivers.kinematic.rooms import ball, box, drive, get_truth, open_robot, post, read_wheel_angles, room, sleep

COUNT = math.tau / 960
WORLD = room(box(1.2, 0.0, 0.2, 1.0), ball(0.9, 0.3))


def camera(robot: Robot) -> Camera:
    return robot.camera


def nose(robot: Robot) -> RangeSensor:
    return robot.range


def test_encoders_return_whole_counts_of_their_wheel() -> None:
    with open_robot() as robot:
        drive(robot, 0.2, 0.8, 1.0)
        sleep(robot, 2.0)
        angles = read_wheel_angles(robot)
        true = [(0.2 + side * 0.8 * 0.155 / 2) / 0.0325 for side in (-1, 1)]
        for angle, turned in zip(angles, true, strict=True):
            assert angle / COUNT == pytest.approx(round(angle / COUNT), abs=1e-6)
            assert abs(turned - angle) <= COUNT / 2


@pytest.mark.parametrize("turned, count", [(-0.4, 0), (-0.6, -1)])
def test_negative_angles_are_rounded_to_the_nearest_count(turned: float, count: int) -> None:
    with open_robot() as robot:
        drive(robot, turned * COUNT * 0.0325 / 0.1, 0.0, 0.1)
        sleep(robot, 1.0)
        assert read_wheel_angles(robot) == pytest.approx((count * COUNT, count * COUNT))


def test_two_runs_are_bitwise_equal() -> None:
    runs = []
    for _ in range(2):
        with open_robot(WORLD) as robot:
            drive(robot, 0.2, 0.7, 1.5)
            image = camera(robot).read().image.tobytes()
            runs.append((get_truth(robot).pose(), nose(robot).read(), image))
    assert runs[0] == runs[1]


HERE = Pose(0.0, 0.0, 0.0)


def sonar(world: WorldDescription, cone: float = 0.5, z: float = 0.1, yaw: float = 0.0) -> Sonar:
    return Sonar(
        RangeSensorDescription(
            kind="range_sensor",
            name="nose",
            mount=Mount(x_m=0.1, z_m=z, yaw_rad=yaw),
            min_range_m=0.02,
            max_range_m=2.0,
            cone_rad=cone,
        ),
        world,
    )


def test_a_ball_is_round() -> None:
    assert sonar(room(ball(1.1, 0.0))).measure(HERE).distance == pytest.approx(0.9)
    exact = math.sqrt(0.1**2 - 0.05**2)
    assert sonar(room(ball(1.1, 0.05)), cone=0.0).measure(HERE).distance == pytest.approx(1.0 - exact)


def test_a_ball_is_cut_at_the_height_of_the_sensor() -> None:
    half_way_up = math.sqrt(0.1**2 - 0.05**2)
    assert sonar(room(ball(1.1, 0.0)), z=0.15).measure(HERE).distance == pytest.approx(1.0 - half_way_up)
    assert math.isinf(sonar(room(ball(1.1, 0.0)), z=0.21).measure(HERE).distance)


def test_box_below_the_sensor_is_not_detected() -> None:
    low, high = box(0.7, 0.0, 0.2, 2.0, height=0.08), box(1.2, 0.0, 0.2, 2.0, name="high")
    assert sonar(room(low, high)).measure(HERE).distance == pytest.approx(1.0)


@pytest.mark.parametrize("yaw", [0.0, 1.2, -2.0, math.pi])
def test_sensor_measures_in_the_direction_of_its_mount(yaw: float) -> None:
    wall = room(box(0.1 + 0.7 * math.cos(yaw), 0.7 * math.sin(yaw), 0.2, 2.0, yaw=yaw))
    echo = sonar(wall, yaw=yaw).measure(HERE)
    assert echo.distance == pytest.approx(0.6)
    assert echo.point == pytest.approx((0.6, 0.0, 0.0))


@pytest.mark.slow
def test_distance_equals_a_numerical_search_along_the_rays() -> None:
    world = room(ball(0.9, 0.1), post(1.2, -0.3, 0.15), box(1.0, 0.5, 0.3, 0.1, yaw=0.5))
    origin, steps = np.array((0.1 - 0.05, 0.0)), np.linspace(0.0, 2.0, 20001)
    found = []
    for angle in np.linspace(-0.3, 0.3, 15):
        points = origin + steps[:, None] * (math.cos(angle), math.sin(angle))
        inside = np.hypot(points[:, 0] - 0.9, points[:, 1] - 0.1) < 0.1
        for prism in world.prisms:
            inside |= _is_inside(points, prism.outline)
        found.append(steps[inside.argmax()] if inside.any() else math.inf)
    assert sonar(world, cone=0.6).measure(HERE).distance == pytest.approx(min(found) - 0.05, abs=2e-4)


def _is_inside(points: np.ndarray, outline: tuple[tuple[float, float], ...]) -> np.ndarray:
    corners = np.array(outline)
    ways = np.roll(corners, -1, axis=0) - corners
    to_points = points[:, None] - corners
    return np.asarray((ways[:, 0] * to_points[..., 1] - ways[:, 1] * to_points[..., 0] >= 0).all(axis=1))
