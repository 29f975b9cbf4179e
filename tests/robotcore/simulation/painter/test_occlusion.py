from __future__ import annotations

import numpy as np

from robotcore.simulation.painter.occlusion import OcclusionPlanes, find_disjoint_columns, sort_back_to_front

NEAR = ((1.0, 0.5), (0.5, 0.5), (0.5, -0.5), (1.0, -0.5))
FAR = ((2.0, 0.5), (1.5, 0.5), (1.5, -0.5), (2.0, -0.5))
NO_DISCS = np.empty((0, 3))


def test_of_two_boxes_the_one_on_the_eyes_side_hides_the_other() -> None:
    partitions = OcclusionPlanes([NEAR, FAR], NO_DISCS)
    assert partitions.find_hidden_pairs(np.array((0.0, 0.0))).tolist() == [[False, False], [True, False]]
    assert partitions.find_hidden_pairs(np.array((3.0, 0.0))).tolist() == [[False, True], [False, False]]


def test_seen_from_between_neither_hides_the_other() -> None:
    assert not OcclusionPlanes([NEAR, FAR], NO_DISCS).find_hidden_pairs(np.array((1.25, 0.0))).any()


def test_a_ball_off_a_corner_is_parted_from_it() -> None:
    disc = np.array(((1.07, 0.57, 0.09),))
    assert OcclusionPlanes([NEAR], disc).find_hidden_pairs(np.array((2.0, 2.0))).tolist() == [
        [False, True],
        [False, False],
    ]
    assert OcclusionPlanes([NEAR], disc).find_hidden_pairs(np.array((0.0, -1.0))).tolist() == [
        [False, False],
        [True, False],
    ]


def test_a_ball_that_reaches_past_a_side_is_not_parted_by_it() -> None:
    disc = np.array(((0.45, 0.8, 0.1),))
    assert OcclusionPlanes([NEAR], disc).find_hidden_pairs(np.array((0.0, 0.4))).tolist() == [
        [False, False],
        [True, False],
    ]


def test_of_two_balls_the_nearer_hides_the_other() -> None:
    discs = np.array(((1.0, 0.0, 0.1), (2.0, 0.0, 0.5)))
    assert OcclusionPlanes([], discs).find_hidden_pairs(np.array((0.0, 0.0))).tolist() == [
        [False, False],
        [True, False],
    ]


def test_what_hides_comes_after_what_it_hides() -> None:
    hidden_by = np.zeros((4, 4), dtype=bool)
    hidden_by[[0, 2, 1], [2, 1, 3]] = True
    assert sort_back_to_front(hidden_by) == [0, 2, 1, 3]


def test_a_ring_is_painted_all_the_same() -> None:
    assert sorted(sort_back_to_front(np.roll(np.eye(3, dtype=bool), 1, axis=0))) == [0, 1, 2]


def test_things_share_a_column_only_where_their_parts_do() -> None:
    apart = find_disjoint_columns([[(0.0, 4.0), (4.0, 6.0)], [(6.5, 9.0)], [(5.0, 7.0)]])
    assert apart.tolist() == [[False, True, False], [True, False, False], [False, False, False]]
