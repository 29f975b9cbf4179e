from __future__ import annotations

import numpy as np

from robotcore.simulation.painter.occlusion import OcclusionPlanes, find_disjoint_columns, sort_back_to_front

NEAR = ((1.0, 0.5), (0.5, 0.5), (0.5, -0.5), (1.0, -0.5))
FAR = ((2.0, 0.5), (1.5, 0.5), (1.5, -0.5), (2.0, -0.5))
NO_DISCS = np.empty((0, 3))


def test_box_nearer_to_the_camera_hides_the_other_box() -> None:
    planes = OcclusionPlanes([NEAR, FAR], NO_DISCS)
    assert planes.find_hidden_pairs(np.array((0.0, 0.0))).tolist() == [[False, False], [True, False]]
    assert planes.find_hidden_pairs(np.array((3.0, 0.0))).tolist() == [[False, True], [False, False]]


def test_camera_between_two_boxes_sees_no_occlusion() -> None:
    assert not OcclusionPlanes([NEAR, FAR], NO_DISCS).find_hidden_pairs(np.array((1.25, 0.0))).any()


def test_plane_separates_a_ball_from_a_corner() -> None:
    disc = np.array(((1.07, 0.57, 0.09),))
    assert OcclusionPlanes([NEAR], disc).find_hidden_pairs(np.array((2.0, 2.0))).tolist() == [
        [False, True],
        [False, False],
    ]
    assert OcclusionPlanes([NEAR], disc).find_hidden_pairs(np.array((0.0, -1.0))).tolist() == [
        [False, False],
        [True, False],
    ]


def test_plane_of_a_side_does_not_separate_a_ball_that_crosses_it() -> None:
    disc = np.array(((0.45, 0.8, 0.1),))
    assert OcclusionPlanes([NEAR], disc).find_hidden_pairs(np.array((0.0, 0.4))).tolist() == [
        [False, False],
        [True, False],
    ]


def test_nearer_of_two_balls_hides_the_other() -> None:
    discs = np.array(((1.0, 0.0, 0.1), (2.0, 0.0, 0.5)))
    assert OcclusionPlanes([], discs).find_hidden_pairs(np.array((0.0, 0.0))).tolist() == [
        [False, False],
        [True, False],
    ]


def test_part_comes_after_the_parts_that_it_hides() -> None:
    hidden = np.zeros((4, 4), dtype=bool)
    hidden[[0, 2, 1], [2, 1, 3]] = True
    assert sort_back_to_front(hidden) == [0, 2, 1, 3]


def test_cycle_of_parts_is_sorted_without_an_error() -> None:
    assert sorted(sort_back_to_front(np.roll(np.eye(3, dtype=bool), 1, axis=0))) == [0, 1, 2]


def test_parts_are_disjoint_if_none_of_their_strokes_share_a_column() -> None:
    apart = find_disjoint_columns([[(0.0, 4.0), (4.0, 6.0)], [(6.5, 9.0)], [(5.0, 7.0)]])
    assert apart.tolist() == [[False, True, False], [True, False, False], [False, False, False]]
