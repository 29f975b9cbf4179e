from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.description import Floor, Start, is_solvable, load_robot, load_world, world_names
from robotcore.description.generation.reachability import FreeSpace, is_target_hidden, is_target_in_view, visible_parts
from robotcore.raycast import edges_of
from tests.robotcore.description.worlds import ball, box, room

ROVER = load_robot("rover")


def wall_with_door(width: float) -> tuple[object, ...]:
    """Return a wall across the room, with a door in its middle."""
    length = 2 - width / 2
    halves = [
        box(name, y_m=y, length_m=0.1, width_m=length) for name, y in (("s", -1 - width / 4), ("n", 1 + width / 4))
    ]
    return (*halves, ball(x_m=1.3))


def test_open_ground_is_solvable() -> None:
    assert is_solvable(room(ball(x_m=1.0)), ROVER)


@pytest.mark.parametrize("door, is_passable", [(0.45, True), (0.28, False), (0.0, False)])
def test_door_must_be_wide_enough_for_the_turning_robot(door: float, is_passable: bool) -> None:
    assert is_solvable(room(*wall_with_door(door)), ROVER) is is_passable  # type: ignore[arg-type]


def test_ball_blocks_the_path() -> None:
    sides = [box(name, x_m=0.0, y_m=y, length_m=0.1, width_m=1.6) for name, y in (("s", -1.2), ("n", 1.2))]
    beyond = ball(x_m=1.3)
    assert is_solvable(room(*sides, beyond), ROVER)
    barred = room(*sides, beyond, ball("plug"))
    assert not is_solvable(barred, ROVER)


def test_ball_that_is_hidden_from_all_arrivals_is_not_reachable() -> None:
    around = [
        box(name, x_m=1.0 + x, y_m=y, length_m=0.1 + 0.4 * bool(y), width_m=0.1 + 0.4 * bool(x))
        for name, x, y in (("w", -0.2, 0.0), ("e", 0.2, 0.0), ("s", 0.0, -0.2), ("n", 0.0, 0.2))
    ]
    assert not is_solvable(room(*around, ball(x_m=1.0)), ROVER)


def test_path_may_leave_the_floor_of_a_world_without_walls() -> None:
    across = box(length_m=0.1, width_m=4.0)
    assert not is_solvable(room(across, ball(x_m=1.3)), ROVER)
    assert is_solvable(room(across, ball(x_m=1.3), walls=None), ROVER)


def test_a_start_in_a_dead_end_is_not_solvable() -> None:
    assert not is_solvable(room(ball(x_m=1.0), start=Start(x_m=-1.9, y_m=-1.9)), ROVER)


def test_world_without_target_or_robot_without_drive_is_solvable() -> None:
    assert is_solvable(room(), ROVER)
    assert is_solvable(room(*wall_with_door(0.0)), load_robot("lookout"))  # type: ignore[arg-type]


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


SEEING_ROVER, LOOKOUT = load_robot("rover"), load_robot("lookout")
WEST = Start(x_m=-1.5)


def test_ball_on_open_ground_is_not_hidden_at_any_heading() -> None:
    for yaw in (0.0, math.pi):
        assert not is_target_hidden(room(ball(x_m=1.0), start=Start(x_m=-1.5, yaw_rad=yaw)), SEEING_ROVER)


def test_a_ball_behind_a_box_is_hidden() -> None:
    assert is_target_hidden(room(box(), ball(x_m=1.0), start=WEST), SEEING_ROVER)


def test_ball_that_is_partly_beside_a_box_is_not_hidden() -> None:
    assert not is_target_hidden(room(box(), ball(x_m=1.0, y_m=0.35), start=WEST), SEEING_ROVER)


def test_a_ball_that_is_seen_by_turning_on_the_spot_is_not_hidden() -> None:
    screen = box(x_m=-0.4, y_m=-0.5, length_m=0.1, width_m=1.16)
    world = room(screen, ball(x_m=1.0), start=WEST)
    edges = edges_of([screen.outline])
    assert not visible_parts(np.array([(-1.5, 0.0)]), world.targets[0], edges).any()
    assert not is_target_hidden(world, SEEING_ROVER)


def test_obstacle_lower_than_the_ball_or_the_camera_hides_nothing() -> None:
    assert not is_target_hidden(room(box(height_m=0.15), ball(x_m=1.0), start=WEST), SEEING_ROVER)
    assert not is_target_hidden(room(box(height_m=0.4), ball(x_m=1.0), start=WEST), LOOKOUT)


def test_a_world_without_a_target_hides_nothing() -> None:
    assert not is_target_hidden(room(), SEEING_ROVER)
    assert not is_target_in_view(room(), SEEING_ROVER)


def test_target_is_in_view_only_in_the_direction_of_the_camera() -> None:
    assert is_target_in_view(room(ball(x_m=0.5), start=WEST), LOOKOUT)
    assert not is_target_in_view(room(ball(x_m=0.5), start=Start(x_m=-1.5, yaw_rad=1.0)), LOOKOUT)
    assert not is_target_in_view(room(box(x_m=-0.5), ball(x_m=0.5), start=WEST), LOOKOUT)


def test_parts_across_the_ball_are_reported_from_right_to_left() -> None:
    right_half_hidden = edges_of([((1.0, -1.0), (1.0, 0.0))])
    seen = visible_parts(np.array([(0.0, -0.001)]), ball(x_m=2.0), right_half_hidden)
    assert seen.tolist() == [[False, False, False, False, True, True, True]]
