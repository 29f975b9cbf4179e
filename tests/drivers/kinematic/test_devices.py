"""Devices of the built-in simulator, and the fan of rays of its range sensors."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.kinematic.devices import Sonar
from robotcore.description import Mount, RangeSensorDescription, Walls, WorldDescription
from robotcore.geometry import Pose
from robotcore.hal.devices import Camera, Encoder, Image, RangeSensor
from robotcore.hal.robot import Robot
from robotcore.optics import CameraView
from robotcore.simulation.painter import Painter
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


def test_reads_at_the_same_time_return_the_same_sample() -> None:
    with open_robot(WORLD) as robot:
        encoder = robot["left_encoder"]
        assert isinstance(encoder, Encoder)
        for sensor in (camera(robot), nose(robot), encoder):
            assert sensor.read() is sensor.read()


def test_samples_have_increasing_sequences_and_their_time() -> None:
    with open_robot(WORLD) as robot:
        taken = []
        for _ in range(3):
            taken.append((nose(robot).read().sequence, nose(robot).read().time))
            sleep(robot, 0.25)
    assert taken == [(0, 0.0), (1, 0.25), (2, 0.5)]


def test_picture_is_read_only_and_does_not_change() -> None:
    with open_robot(WORLD) as robot:
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


def test_picture_is_painted_only_when_it_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    painted: list[CameraView] = []
    paint = Painter.picture

    def count_picture(painter: Painter, view: CameraView) -> Image:
        painted.append(view)
        return paint(painter, view)

    monkeypatch.setattr(Painter, "picture", count_picture)
    with open_robot(WORLD) as robot:
        drive(robot, 0.1, 0.0, 1.0)
        assert not painted
        camera(robot).read()
        camera(robot).read()
    assert len(painted) == 1


def test_ball_on_the_left_is_green_and_left_in_the_picture() -> None:
    with open_robot(WORLD) as robot:
        blue, green, red = camera(robot).read().image.astype(int).transpose(2, 0, 1)
    rows, columns = np.nonzero((green > blue + 40) & (green > red + 40))
    assert len(rows) > 500
    assert columns.mean() < 150


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


def test_distance_is_from_the_sensor_to_the_wall() -> None:
    echo = sonar(room(box(0.7, 0.0, 0.2, 2.0))).measure(HERE)
    assert echo.distance == pytest.approx(0.5)
    assert echo.point == pytest.approx((0.5, 0.0, 0.0))


def test_nothing_in_range_is_inf_without_a_point() -> None:
    assert sonar(room()).measure(HERE) == (math.inf, None)
    assert sonar(room(box(2.3, 0.0, 0.1, 2.0))).measure(HERE) == (math.inf, None)


@pytest.mark.parametrize("gap", [0.0, 0.001, 0.0199])
def test_touching_reads_the_minimum(gap: float) -> None:
    assert sonar(room(box(0.15 + gap, 0.0, 0.1, 2.0))).measure(HERE).distance == 0.02


def test_post_beside_the_axis_is_detected_in_the_cone() -> None:
    aside = room(post(1.1, 0.25, 0.1))
    assert math.isfinite(sonar(aside, cone=0.5).measure(HERE).distance)
    assert math.isinf(sonar(aside, cone=0.1).measure(HERE).distance)


def test_point_is_on_the_surface_of_the_post() -> None:
    echo = sonar(room(post(0.9, 0.2, 0.05)), cone=0.6).measure(HERE)
    assert echo.point
    x, y, z = echo.point
    assert math.hypot(x + 0.1 - 0.9, y - 0.2) == pytest.approx(0.05, abs=1e-3)
    assert z == 0.0


def test_a_ball_is_round() -> None:
    assert sonar(room(ball(1.1, 0.0))).measure(HERE).distance == pytest.approx(0.9)
    exact = math.sqrt(0.1**2 - 0.05**2)
    assert sonar(room(ball(1.1, 0.05)), cone=0.0).measure(HERE).distance == pytest.approx(1.0 - exact)


def test_a_ball_is_cut_at_the_height_of_the_sensor() -> None:
    half_way_up = math.sqrt(0.1**2 - 0.05**2)
    assert sonar(room(ball(1.1, 0.0)), z=0.15).measure(HERE).distance == pytest.approx(1.0 - half_way_up)
    assert math.isinf(sonar(room(ball(1.1, 0.0)), z=0.21).measure(HERE).distance)


def test_ball_behind_the_sensor_is_not_detected() -> None:
    assert sonar(room(ball(-0.5, 0.0))).measure(HERE) == (math.inf, None)


def test_box_below_the_sensor_is_not_detected() -> None:
    low, high = box(0.7, 0.0, 0.2, 2.0, height=0.08), box(1.2, 0.0, 0.2, 2.0, name="high")
    assert sonar(room(low, high)).measure(HERE).distance == pytest.approx(1.0)


def test_distance_is_that_of_the_nearest_body() -> None:
    behind = room(ball(0.8, 0.0), walls=Walls(height_m=0.3))
    assert sonar(behind).measure(HERE).distance == pytest.approx(0.6)


@pytest.mark.parametrize("yaw", [0.0, 1.2, -2.0, math.pi])
def test_sensor_measures_in_the_direction_of_its_mount(yaw: float) -> None:
    wall = room(box(0.1 + 0.7 * math.cos(yaw), 0.7 * math.sin(yaw), 0.2, 2.0, yaw=yaw))
    echo = sonar(wall, yaw=yaw).measure(HERE)
    assert echo.distance == pytest.approx(0.6)
    assert echo.point == pytest.approx((0.6, 0.0, 0.0))


def test_distance_depends_on_the_pose_of_the_robot() -> None:
    pose = Pose(0.3, -0.2, 0.7)
    x, y = pose.to_world(1.1, 0.0)
    assert sonar(room(ball(x, y))).measure(pose).distance == pytest.approx(0.9)


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
