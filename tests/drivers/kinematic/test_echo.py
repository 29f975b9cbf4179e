from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.kinematic.echo import Sonar
from robotcore.description import Mount, RangeSensorDescription, Walls, WorldDescription
from robotcore.geometry import Pose
from tests.drivers.kinematic.rooms import ball, box, post, room

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
    echo = sonar(room(box(0.7, 0.0, 0.2, 2.0))).listen(HERE)
    assert echo.distance == pytest.approx(0.5)
    assert echo.point == pytest.approx((0.5, 0.0, 0.0))


def test_nothing_in_range_is_inf_without_a_point() -> None:
    assert sonar(room()).listen(HERE) == (math.inf, None)
    assert sonar(room(box(2.3, 0.0, 0.1, 2.0))).listen(HERE) == (math.inf, None)


@pytest.mark.parametrize("gap", [0.0, 0.001, 0.0199])
def test_touching_reads_the_minimum(gap: float) -> None:
    assert sonar(room(box(0.15 + gap, 0.0, 0.1, 2.0))).listen(HERE).distance == 0.02


def test_the_cone_hears_what_the_axis_misses() -> None:
    aside = room(post(1.1, 0.25, 0.1))
    assert math.isfinite(sonar(aside, cone=0.5).listen(HERE).distance)
    assert math.isinf(sonar(aside, cone=0.1).listen(HERE).distance)


def test_the_point_is_on_the_side_that_is_hit() -> None:
    echo = sonar(room(post(0.9, 0.2, 0.05)), cone=0.6).listen(HERE)
    assert echo.point
    x, y, z = echo.point
    assert math.hypot(x + 0.1 - 0.9, y - 0.2) == pytest.approx(0.05, abs=1e-3)
    assert z == 0.0


def test_a_ball_is_round() -> None:
    assert sonar(room(ball(1.1, 0.0))).listen(HERE).distance == pytest.approx(0.9)
    exact = math.sqrt(0.1**2 - 0.05**2)
    assert sonar(room(ball(1.1, 0.05)), cone=0.0).listen(HERE).distance == pytest.approx(1.0 - exact)


def test_a_ball_is_cut_at_the_height_of_the_sensor() -> None:
    half_way_up = math.sqrt(0.1**2 - 0.05**2)
    assert sonar(room(ball(1.1, 0.0)), z=0.15).listen(HERE).distance == pytest.approx(1.0 - half_way_up)
    assert math.isinf(sonar(room(ball(1.1, 0.0)), z=0.21).listen(HERE).distance)


def test_a_ball_behind_is_not_heard() -> None:
    assert sonar(room(ball(-0.5, 0.0))).listen(HERE) == (math.inf, None)


def test_rays_pass_over_what_is_lower_than_the_sensor() -> None:
    low, high = box(0.7, 0.0, 0.2, 2.0, height=0.08), box(1.2, 0.0, 0.2, 2.0, name="high")
    assert sonar(room(low, high)).listen(HERE).distance == pytest.approx(1.0)


def test_the_nearest_of_several_is_heard() -> None:
    behind = room(ball(0.8, 0.0), walls=Walls(height_m=0.3))
    assert sonar(behind).listen(HERE).distance == pytest.approx(0.6)


@pytest.mark.parametrize("yaw", [0.0, 1.2, -2.0, math.pi])
def test_a_sensor_hears_where_it_is_mounted_to_look(yaw: float) -> None:
    wall = room(box(0.1 + 0.7 * math.cos(yaw), 0.7 * math.sin(yaw), 0.2, 2.0, yaw=yaw))
    echo = sonar(wall, yaw=yaw).listen(HERE)
    assert echo.distance == pytest.approx(0.6)
    assert echo.point == pytest.approx((0.6, 0.0, 0.0))


def test_an_echo_moves_with_the_robot() -> None:
    pose = Pose(0.3, -0.2, 0.7)
    x, y = pose.to_world(1.1, 0.0)
    assert sonar(room(ball(x, y))).listen(pose).distance == pytest.approx(0.9)


def test_lengths_are_those_of_a_search_along_each_ray() -> None:
    world = room(ball(0.9, 0.1), post(1.2, -0.3, 0.15), box(1.0, 0.5, 0.3, 0.1, yaw=0.5))
    origin, steps = np.array((0.1 - 0.05, 0.0)), np.linspace(0.0, 2.0, 20001)
    found = []
    for angle in np.linspace(-0.3, 0.3, 15):
        points = origin + steps[:, None] * (math.cos(angle), math.sin(angle))
        inside = np.hypot(points[:, 0] - 0.9, points[:, 1] - 0.1) < 0.1
        for prism in world.prisms:
            inside |= _is_inside(points, prism.outline)
        found.append(steps[inside.argmax()] if inside.any() else math.inf)
    assert sonar(world, cone=0.6).listen(HERE).distance == pytest.approx(min(found) - 0.05, abs=2e-4)


def _is_inside(points: np.ndarray, outline: tuple[tuple[float, float], ...]) -> np.ndarray:
    corners = np.array(outline)
    ways = np.roll(corners, -1, axis=0) - corners
    to_points = points[:, None] - corners
    return np.asarray((ways[:, 0] * to_points[..., 1] - ways[:, 1] * to_points[..., 0] >= 0).all(axis=1))
