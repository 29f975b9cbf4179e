from __future__ import annotations

import math

import pytest

from robotcore.description import COLOURS, Ball, Box, Floor, WorldDescription
from robotcore.geometry import Pose, Twist
from robotcore.hal.truth import Truth
from tests.robotcore.fakes import ROVER, STANDING, StillTruth

FRONT = ROVER.body.front_x_m
RADIUS = 0.1
ORIGIN = Pose(0.0, 0.0, 0.0)


def wall(x: float, y: float, length: float = 0.1, width: float = 0.6) -> Box:
    return Box(
        shape="box", name="wall", x_m=x, y_m=y, length_m=length, width_m=width, height_m=0.5, colour=COLOURS["white"]
    )


def truth(
    *balls: tuple[float, float], pose: Pose = ORIGIN, twist: Twist = STANDING, walls: tuple[Box, ...] = ()
) -> Truth:
    world = WorldDescription(
        name="w",
        floor=Floor(length_m=20.0, width_m=20.0),
        targets=tuple(
            Ball(name=f"b{i}", radius_m=RADIUS, colour=COLOURS["green"], x_m=x, y_m=y) for i, (x, y) in enumerate(balls)
        ),
        obstacles=walls,
    )
    return Truth(StillTruth(pose, twist, contacts=2), ROVER, world)


def test_pose_and_contacts_are_those_of_the_simulator() -> None:
    answer = truth(pose=Pose(1.0, 2.0, 3.0))
    assert (answer.pose, answer.contacts) == (Pose(1.0, 2.0, 3.0), 2)


@pytest.mark.parametrize(
    "twist, is_at_rest",
    [
        (Twist(0.0, 0.0), True),
        (Twist(0.009, -0.049), True),
        (Twist(-0.011, 0.0), False),
        (Twist(0.0, -0.051), False),
    ],
)
def test_robot_is_at_rest_below_both_limits(twist: Twist, is_at_rest: bool) -> None:
    assert truth(twist=twist).is_at_rest is is_at_rest


class TestDistanceToTarget:
    def test_distance_is_from_the_front_to_the_surface(self) -> None:
        assert truth((1.0, 0.0), (0.5, 0.0)).distance_to_target == pytest.approx(1.0 - FRONT - RADIUS)

    def test_distance_is_from_the_nearest_point_of_the_front(self) -> None:
        assert truth((1.0, ROVER.body.width_m / 2)).distance_to_target == pytest.approx(1.0 - FRONT - RADIUS)
        aside = truth((FRONT + 0.3, ROVER.body.width_m / 2 + 0.4))
        assert aside.distance_to_target == pytest.approx(0.5 - RADIUS)

    def test_distance_does_not_depend_on_the_robots_pose(self) -> None:
        pose = Pose(3.0, -2.0, 2.0)
        assert truth(pose.to_world(0.5, -0.3), pose=pose).distance_to_target == pytest.approx(
            truth((0.5, -0.3)).distance_to_target
        )

    def test_distance_is_none_without_a_target(self) -> None:
        assert truth().distance_to_target is None


class TestSeesTarget:
    @pytest.mark.parametrize("heading", [math.pi / 2, math.pi, -math.pi / 2])
    def test_ball_outside_the_picture_is_not_visible(self, heading: float) -> None:
        assert not truth((1.0, 0.0), pose=Pose(0.0, 0.0, heading)).sees_target

    def test_ball_at_the_edge_of_the_picture_is_visible(self) -> None:
        half = math.radians(31)
        assert truth(_at(1.0, half + 0.03)).sees_target
        assert not truth(_at(1.0, half + 0.12)).sees_target

    def test_a_wall_behind_the_ball_hides_nothing(self) -> None:
        assert truth((1.0, 0.0), walls=(wall(1.3, 0.0),)).sees_target

    def test_ball_that_is_half_behind_a_wall_is_visible(self) -> None:
        assert truth((1.0, 0.0), walls=(wall(0.6, 0.3),)).sees_target
        assert not truth((1.0, 0.0), walls=(wall(0.6, 0.2),)).sees_target

    def test_nothing_is_visible_without_a_target_or_a_camera(self) -> None:
        assert not truth().sees_target
        blind = ROVER.model_copy(update={"devices": ()})
        world = WorldDescription(name="w", floor=Floor(length_m=9.0, width_m=9.0))
        assert not Truth(StillTruth(ORIGIN), blind, world).sees_target


def _at(distance: float, bearing: float) -> tuple[float, float]:
    """Return x and y of a ball at a distance and a bearing from the rover's camera."""
    return Pose(0.14, 0.0, 0.0).to_world(distance * math.cos(bearing), distance * math.sin(bearing))
