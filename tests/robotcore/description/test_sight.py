from __future__ import annotations

import math

import numpy as np

from robotcore.description import Start, load_robot
from robotcore.description.sight import is_target_hidden, is_target_in_view, visible_parts
from robotcore.raycast import edges_of
from tests.robotcore.description.worlds import ball, box, room

ROVER, LOOKOUT = load_robot("rover"), load_robot("lookout")
WEST = Start(x_m=-1.5)


def test_a_ball_on_open_ground_is_not_hidden_whichever_way_the_robot_looks() -> None:
    for yaw in (0.0, math.pi):
        assert not is_target_hidden(room(ball(x_m=1.0), start=Start(x_m=-1.5, yaw_rad=yaw)), ROVER)


def test_a_ball_behind_a_box_is_hidden() -> None:
    assert is_target_hidden(room(box(), ball(x_m=1.0), start=WEST), ROVER)


def test_a_ball_that_stands_out_beside_a_box_is_not_hidden() -> None:
    assert not is_target_hidden(room(box(), ball(x_m=1.0, y_m=0.35), start=WEST), ROVER)


def test_a_ball_that_is_seen_by_turning_on_the_spot_is_not_hidden() -> None:
    screen = box(x_m=-0.4, y_m=-0.5, length_m=0.1, width_m=1.16)
    world = room(screen, ball(x_m=1.0), start=WEST)
    edges = edges_of([screen.outline])
    assert not visible_parts(np.array([(-1.5, 0.0)]), world.targets[0], edges).any()
    assert not is_target_hidden(world, ROVER)


def test_what_is_lower_than_the_ball_or_the_camera_hides_nothing() -> None:
    assert not is_target_hidden(room(box(height_m=0.15), ball(x_m=1.0), start=WEST), ROVER)
    assert not is_target_hidden(room(box(height_m=0.4), ball(x_m=1.0), start=WEST), LOOKOUT)


def test_a_world_without_a_target_hides_nothing() -> None:
    assert not is_target_hidden(room(), ROVER)
    assert not is_target_in_view(room(), ROVER)


def test_a_target_is_in_view_only_where_the_camera_looks() -> None:
    assert is_target_in_view(room(ball(x_m=0.5), start=WEST), LOOKOUT)
    assert not is_target_in_view(room(ball(x_m=0.5), start=Start(x_m=-1.5, yaw_rad=1.0)), LOOKOUT)
    assert not is_target_in_view(room(box(x_m=-0.5), ball(x_m=0.5), start=WEST), LOOKOUT)


def test_parts_across_the_ball_are_told_from_right_to_left() -> None:
    right_half_hidden = edges_of([((1.0, -1.0), (1.0, 0.0))])
    seen = visible_parts(np.array([(0.0, -0.001)]), ball(x_m=2.0), right_half_hidden)
    assert seen.tolist() == [[False, False, False, False, True, True, True]]
