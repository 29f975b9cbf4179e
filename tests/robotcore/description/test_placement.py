from __future__ import annotations

import math

import pytest

from robotcore.description import Start, WorldDescription, load_robot, require_room, require_start
from robotcore.errors import DescriptionError
from tests.robotcore.description.worlds import ball, box, room


def fault_of(world: WorldDescription) -> DescriptionError:
    with pytest.raises(DescriptionError) as caught:
        require_room(world, "my.toml")
    assert "\n" not in str(caught.value)
    return caught.value


def test_things_apart_have_room() -> None:
    require_room(room(box(), ball(x_m=1.0), ball("other", x_m=-1.0)), "my.toml")


def test_a_ball_in_an_obstacle_is_named_with_it() -> None:
    fault = fault_of(room(box(), ball(x_m=0.3)))
    assert (fault.file, fault.key) == ("my.toml", "targets[ball]")
    assert "the obstacle 'box'" in fault.fault


def test_two_balls_in_one_place_are_refused() -> None:
    assert "the target 'ball'" in fault_of(room(ball(), ball("other", x_m=0.15))).fault


@pytest.mark.parametrize("x", [1.95, 3.0, -1.95])
def test_a_ball_in_or_beyond_a_wall_is_refused(x: float) -> None:
    fault = fault_of(room(ball(x_m=x)))
    assert "wall" in fault.fault
    assert "±2 m" in fault.remedy


def test_without_walls_a_ball_may_lie_beyond_the_floor() -> None:
    require_room(room(ball(x_m=3.0), walls=None), "my.toml")


def test_obstacles_may_overlap_to_build_an_l() -> None:
    require_room(room(box(), box("leg", x_m=0.4)), "my.toml")


def test_an_obstacle_may_reach_into_a_wall_but_not_stand_beyond_it() -> None:
    require_room(room(box(x_m=1.9)), "my.toml")
    assert fault_of(room(box(x_m=2.1))).key == "obstacles[box]"


@pytest.mark.parametrize("thing", [box(x_m=-1.4, y_m=-1.4), ball(x_m=-1.45, y_m=-1.5)])
def test_a_start_in_a_thing_is_refused(thing: object) -> None:
    assert fault_of(room(thing)).key == "start"  # type: ignore[arg-type]


def test_a_start_beyond_a_wall_is_refused() -> None:
    assert fault_of(room(start=Start(x_m=-2.5))).key == "start"


def test_whether_the_start_has_room_depends_on_the_robot() -> None:
    world = room(box(x_m=-1.5, y_m=-1.12))
    require_room(world, "my.toml")
    require_start(world, load_robot("lookout"))
    with pytest.raises(DescriptionError, match=r"the world 'room': start: the robot 'rover' is in the obstacle 'box'"):
        require_start(room(box(x_m=-1.2, y_m=-1.5)), load_robot("rover"))


def test_whether_the_start_has_room_depends_on_the_heading() -> None:
    nearby = box(x_m=-1.5, y_m=-1.13)
    require_start(room(nearby, start=Start(x_m=-1.5, y_m=-1.5, yaw_rad=0.0)), load_robot("rover"))
    with pytest.raises(DescriptionError):
        require_start(room(nearby, start=Start(x_m=-1.5, y_m=-1.5, yaw_rad=math.pi / 2)), load_robot("rover"))
