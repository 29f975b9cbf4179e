from __future__ import annotations

import math
from random import Random

import pytest

from robotcore.description import Floor, Start, WorldDescription, load_robot, require_room, require_start
from robotcore.description.generation.gaps import compute_gap, gap_to_edge, has_gap
from robotcore.description.world import Outline, round_outline
from robotcore.errors import DescriptionError
from tests.robotcore.description.worlds import ball, box, room
from tests.texts import Raises

SQUARE = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))


def moved(x: float, y: float) -> tuple[tuple[float, float], ...]:
    return tuple((x + corner_x, y + corner_y) for corner_x, corner_y in SQUARE)


LONG = ((3.0, 0.1), (-3.0, 0.1), (-3.0, -0.1), (3.0, -0.1))
TALL = ((0.1, 3.0), (-0.1, 3.0), (-0.1, -3.0), (0.1, -3.0))


@pytest.mark.parametrize(
    "one, other, gap",
    [
        (SQUARE, moved(2.5, 0.7), 0.5),
        (SQUARE, moved(1.9, 0.0), -0.1),
        (LONG, TALL, -3.1),
        (SQUARE, round_outline(0.2, 0.1, 0.05), -0.85),
    ],
    ids=["parallel sides", "overlap", "cross without a corner inside", "one inside the other"],
)
def test_gap_of_overlapping_outlines_is_negative(one: Outline, other: Outline, gap: float) -> None:
    assert compute_gap(one, other) == pytest.approx(gap, abs=0.001)
    assert compute_gap(other, one) == pytest.approx(gap, abs=0.001)


def test_gap_between_corners_is_at_most_their_distance() -> None:
    assert 0 < compute_gap(SQUARE, moved(3.0, 3.0)) <= math.sqrt(2)


def create_random_outline(random: Random) -> Outline:
    x, y = random.uniform(-2, 2), random.uniform(-2, 2)
    if random.random() < 0.5:
        return round_outline(x, y, random.uniform(0.05, 0.5))
    length, width, yaw = random.uniform(0.05, 1.5), random.uniform(0.05, 0.6), random.uniform(-3, 3)
    return box(x_m=x, y_m=y, yaw_rad=yaw, length_m=length, width_m=width).outline


def test_outlines_have_a_gap_if_the_computed_gap_is_as_great() -> None:
    random = Random(3)
    found = set()
    for _ in range(2000):
        one, other, gap = create_random_outline(random), create_random_outline(random), random.uniform(0.0, 0.6)
        found.add(has_gap(one, other, gap))
        assert has_gap(one, other, gap) == (compute_gap(one, other) >= gap)
    assert found == {False, True}


def test_gap_to_the_edge_is_that_of_the_outermost_corner() -> None:
    assert gap_to_edge(moved(0.5, 0.0), Floor(length_m=4, width_m=6)) == pytest.approx(0.5)
    assert gap_to_edge(moved(0.0, -2.5), Floor(length_m=4, width_m=6)) == pytest.approx(-0.5)


@pytest.mark.parametrize(
    "world",
    [
        room(box(), ball(x_m=1.0), ball("other", x_m=-1.0)),
        room(ball(x_m=3.0), walls=None),
        room(box(), box("leg", x_m=0.4)),
        room(box(x_m=1.9)),
    ],
    ids=["gaps", "ball beyond a floor without walls", "obstacles as an L", "obstacle in a wall"],
)
def test_overlaps_of_obstacles_and_bodies_beyond_an_open_floor_are_accepted(world: WorldDescription) -> None:
    require_room(world, "my.toml")


@pytest.mark.parametrize(
    "world, key, kind",
    [
        (room(box(), ball(x_m=0.3)), "targets[ball]", "in-obstacle"),
        (room(ball(), ball("other", x_m=0.15)), "targets[other]", "in-target"),
        (room(ball(x_m=1.95)), "targets[ball]", "beyond-wall"),
        (room(ball(x_m=-1.95)), "targets[ball]", "beyond-wall"),
        (room(box(x_m=2.1)), "obstacles[box]", "beyond-wall"),
        (room(box(x_m=-1.4, y_m=-1.4)), "start", "in-obstacle"),
        (room(ball(x_m=-1.45, y_m=-1.5)), "start", "in-target"),
        (room(start=Start(x_m=-2.5)), "start", "beyond-wall"),
    ],
)
def test_body_or_start_that_overlaps_another_or_is_beyond_a_wall_is_refused(
    raises: Raises, world: WorldDescription, key: str, kind: str
) -> None:
    with raises(DescriptionError, kind, file="my.toml", key=key, others=()):
        require_room(world, "my.toml")


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
