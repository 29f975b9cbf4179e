from __future__ import annotations

import math

import pytest

from robotcore.description import Floor, Start, WorldDescription, load_robot, require_room, require_start
from robotcore.description.generation.clearance import gap_between, gap_to_edge
from robotcore.description.world import round_outline
from robotcore.errors import DescriptionError
from tests.robotcore.description.worlds import ball, box, room
from tests.texts import CheckText, Raises

SQUARE = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))


def moved(x: float, y: float) -> tuple[tuple[float, float], ...]:
    return tuple((x + corner_x, y + corner_y) for corner_x, corner_y in SQUARE)


def test_gap_of_parallel_sides_is_their_distance() -> None:
    assert gap_between(SQUARE, moved(2.5, 0.7)) == pytest.approx(0.5)


def test_gap_of_overlapping_outlines_is_negative() -> None:
    assert gap_between(SQUARE, moved(1.9, 0.0)) == pytest.approx(-0.1)


def test_gap_of_a_cross_is_negative_without_a_corner_inside() -> None:
    long, tall = (
        ((3.0, 0.1), (-3.0, 0.1), (-3.0, -0.1), (3.0, -0.1)),
        ((0.1, 3.0), (-0.1, 3.0), (-0.1, -3.0), (0.1, -3.0)),
    )
    assert gap_between(long, tall) < 0


def test_gap_of_an_outline_inside_another_is_negative() -> None:
    disc = round_outline(0.2, 0.1, 0.05)
    assert gap_between(SQUARE, disc) < 0
    assert gap_between(disc, SQUARE) < 0


def test_gap_between_corners_is_at_most_their_distance() -> None:
    assert 0 < gap_between(SQUARE, moved(3.0, 3.0)) <= math.sqrt(2)


def test_gap_to_the_edge_is_that_of_the_outermost_corner() -> None:
    assert gap_to_edge(moved(0.5, 0.0), Floor(length_m=4, width_m=6)) == pytest.approx(0.5)
    assert gap_to_edge(moved(0.0, -2.5), Floor(length_m=4, width_m=6)) == pytest.approx(-0.5)


def find_error(world: WorldDescription) -> DescriptionError:
    with pytest.raises(DescriptionError) as caught:
        require_room(world, "my.toml")
    assert not caught.value.others
    return caught.value


def test_bodies_with_a_gap_are_accepted() -> None:
    require_room(room(box(), ball(x_m=1.0), ball("other", x_m=-1.0)), "my.toml")


def test_ball_in_an_obstacle_is_refused(check_text: CheckText) -> None:
    error = find_error(room(box(), ball(x_m=0.3)))
    assert (error.file, error.key, error.kind) == ("my.toml", "targets[ball]", "in-obstacle")
    check_text(error)


def test_two_balls_in_one_place_are_refused(check_text: CheckText) -> None:
    error = find_error(room(ball(), ball("other", x_m=0.15)))
    assert (error.key, error.kind) == ("targets[other]", "in-target")
    check_text(error)


@pytest.mark.parametrize("x", [1.95, 3.0, -1.95])
def test_ball_in_or_beyond_a_wall_is_refused(x: float, check_text: CheckText) -> None:
    error = find_error(room(ball(x_m=x)))
    assert (error.key, error.kind) == ("targets[ball]", "beyond-wall")
    check_text(error)


def test_ball_may_be_beyond_the_floor_without_walls() -> None:
    require_room(room(ball(x_m=3.0), walls=None), "my.toml")


def test_obstacles_may_overlap_to_build_an_l() -> None:
    require_room(room(box(), box("leg", x_m=0.4)), "my.toml")


def test_obstacle_may_overlap_a_wall_but_not_be_beyond_it() -> None:
    require_room(room(box(x_m=1.9)), "my.toml")
    assert find_error(room(box(x_m=2.1))).key == "obstacles[box]"


@pytest.mark.parametrize("thing", [box(x_m=-1.4, y_m=-1.4), ball(x_m=-1.45, y_m=-1.5)])
def test_start_in_a_body_is_refused(thing: object) -> None:
    assert find_error(room(thing)).key == "start"  # type: ignore[arg-type]


def test_start_beyond_a_wall_is_refused() -> None:
    assert find_error(room(start=Start(x_m=-2.5))).key == "start"


def test_start_is_refused_if_the_robot_overlaps_an_obstacle(raises: Raises) -> None:
    world = room(box(x_m=-1.5, y_m=-1.12))
    require_room(world, "my.toml")
    require_start(world, load_robot("lookout"))
    with raises(DescriptionError, "in-obstacle", key="start"):
        require_start(room(box(x_m=-1.2, y_m=-1.5)), load_robot("rover"))


def test_start_is_refused_if_the_turned_robot_overlaps_an_obstacle() -> None:
    nearby = box(x_m=-1.5, y_m=-1.13)
    require_start(room(nearby, start=Start(x_m=-1.5, y_m=-1.5, yaw_rad=0.0)), load_robot("rover"))
    with pytest.raises(DescriptionError):
        require_start(room(nearby, start=Start(x_m=-1.5, y_m=-1.5, yaw_rad=math.pi / 2)), load_robot("rover"))
