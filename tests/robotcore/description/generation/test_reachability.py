from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.description import (
    Box,
    Floor,
    RobotDescription,
    Start,
    WorldDescription,
    is_solvable,
    load_robot,
    load_world,
    world_names,
)
from robotcore.description.generation.reachability import FreeSpace, is_target_hidden, is_target_in_view, visible_parts
from robotcore.raycast import edges_of
from tests.robotcore.description.worlds import ball, box, room

ROVER, LOOKOUT = load_robot("rover"), load_robot("lookout")


def wall_with_door(width: float) -> list[Box]:
    """Return a wall across the room, with a door in its middle."""
    length = 2 - width / 2
    return [box(name, y_m=y, length_m=0.1, width_m=length) for name, y in (("s", -1 - width / 4), ("n", 1 + width / 4))]


FAR = ball(x_m=1.3)
SIDES = [box(name, y_m=y, length_m=0.1, width_m=1.6) for name, y in (("s", -1.2), ("n", 1.2))]
FENCE = [
    box(name, x_m=1.3 + x, y_m=y, length_m=0.1 + 0.4 * bool(y), width_m=0.1 + 0.4 * bool(x))
    for name, x, y in (("w", -0.2, 0.0), ("e", 0.2, 0.0), ("s", 0.0, -0.2), ("n", 0.0, 0.2))
]
BARRIER = box(length_m=0.1, width_m=4.0)


@pytest.mark.parametrize(
    "world, is_reached",
    [
        (room(FAR), True),
        (room(*wall_with_door(0.45), FAR), True),
        (room(*wall_with_door(0.28), FAR), False),
        (room(*SIDES, FAR), True),
        (room(*SIDES, FAR, ball("plug")), False),
        (room(*FENCE, FAR), False),
        (room(BARRIER, FAR), False),
        (room(BARRIER, FAR, walls=None), True),
        (room(FAR, start=Start(x_m=-1.9, y_m=-1.9)), False),
        (room(BARRIER), True),
    ],
    ids=[
        *("open ground", "wide door", "narrow door", "gap", "ball in the gap", "hidden ball", "barrier"),
        *("way around on the ground", "start in a corner", "no target"),
    ],
)
def test_world_is_solvable_if_the_turning_robot_can_reach_the_target(
    world: WorldDescription, *, is_reached: bool
) -> None:
    assert is_solvable(world, ROVER) is is_reached
    assert is_solvable(world, LOOKOUT), "it cannot drive"


def test_number_of_cells_is_limited_on_a_large_floor() -> None:
    vast = room(ball(x_m=40.0), floor=Floor(length_m=100, width_m=100))
    assert is_solvable(vast, ROVER)
    assert FreeSpace(vast).cell_m == pytest.approx(0.05)


@pytest.mark.parametrize("name", world_names())
def test_a_shipped_world_is_solvable_as_written(name: str) -> None:
    assert is_solvable(load_world(name), ROVER)


@pytest.mark.parametrize("name, is_hidden", [("arena", True), ("occluded", True), ("clutter", False), ("open", False)])
def test_shipped_world_hides_its_ball_as_described(name: str, is_hidden: bool) -> None:
    assert is_target_hidden(load_world(name), ROVER) is is_hidden


WEST = Start(x_m=-1.5)


@pytest.mark.parametrize(
    "world, robot, is_hidden",
    [
        (room(FAR, start=WEST), ROVER, False),
        (room(FAR, start=Start(x_m=-1.5, yaw_rad=math.pi)), ROVER, False),
        (room(box(), FAR, start=WEST), ROVER, True),
        (room(box(), ball(x_m=1.0, y_m=0.35), start=WEST), ROVER, False),
        (room(box(height_m=0.15), FAR, start=WEST), ROVER, False),
        (room(box(height_m=0.4), FAR, start=WEST), LOOKOUT, False),
        (room(box()), ROVER, False),
    ],
    ids=[
        *("open ground", "behind the robot", "behind a box", "partly beside a box", "box lower than the ball"),
        *("box lower than the camera", "no target"),
    ],
)
def test_target_is_hidden_if_obstacles_hide_all_of_it(
    world: WorldDescription, robot: RobotDescription, *, is_hidden: bool
) -> None:
    assert is_target_hidden(world, robot) is is_hidden


def test_a_ball_that_is_seen_by_turning_on_the_spot_is_not_hidden() -> None:
    screen = box(x_m=-0.4, y_m=-0.5, length_m=0.1, width_m=1.16)
    world = room(screen, ball(x_m=1.0), start=WEST)
    edges = edges_of([screen.outline])
    assert not visible_parts(np.array([(-1.5, 0.0)]), world.targets[0], edges).any()
    assert not is_target_hidden(world, ROVER)


def test_target_is_in_view_only_in_the_direction_of_the_camera() -> None:
    assert is_target_in_view(room(ball(x_m=0.5), start=WEST), LOOKOUT)
    assert not is_target_in_view(room(ball(x_m=0.5), start=Start(x_m=-1.5, yaw_rad=1.0)), LOOKOUT)
    assert not is_target_in_view(room(), LOOKOUT)
    assert not is_target_in_view(room(box(x_m=-0.5), ball(x_m=0.5), start=WEST), LOOKOUT)


def test_parts_across_the_ball_are_reported_from_right_to_left() -> None:
    right_half_hidden = edges_of([((1.0, -1.0), (1.0, 0.0))])
    seen = visible_parts(np.array([(0.0, -0.001)]), ball(x_m=2.0), right_half_hidden)
    assert seen.tolist() == [[False, False, False, False, True, True, True]]
