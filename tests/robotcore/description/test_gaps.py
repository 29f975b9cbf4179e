from __future__ import annotations

import math

import pytest

from robotcore.description import Floor
from robotcore.description.gaps import gap_between, gap_to_edge
from robotcore.description.world import round_outline

SQUARE = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))


def moved(x: float, y: float) -> tuple[tuple[float, float], ...]:
    return tuple((x + corner_x, y + corner_y) for corner_x, corner_y in SQUARE)


def test_outlines_side_by_side_are_as_far_apart_as_their_sides() -> None:
    assert gap_between(SQUARE, moved(2.5, 0.7)) == pytest.approx(0.5)


def test_overlap_is_below_zero() -> None:
    assert gap_between(SQUARE, moved(1.9, 0.0)) == pytest.approx(-0.1)


def test_a_cross_overlaps_although_no_corner_of_one_is_in_the_other() -> None:
    long, tall = (
        ((3.0, 0.1), (-3.0, 0.1), (-3.0, -0.1), (3.0, -0.1)),
        ((0.1, 3.0), (-0.1, 3.0), (-0.1, -3.0), (0.1, -3.0)),
    )
    assert gap_between(long, tall) < 0


def test_an_outline_inside_another_overlaps_both_ways() -> None:
    disc = round_outline(0.2, 0.1, 0.05)
    assert gap_between(SQUARE, disc) < 0
    assert gap_between(disc, SQUARE) < 0


def test_a_gap_between_corners_is_never_more_than_the_distance() -> None:
    assert 0 < gap_between(SQUARE, moved(3.0, 3.0)) <= math.sqrt(2)


def test_the_gap_to_the_edge_is_that_of_the_corner_farthest_out() -> None:
    assert gap_to_edge(moved(0.5, 0.0), Floor(length_m=4, width_m=6)) == pytest.approx(0.5)
    assert gap_to_edge(moved(0.0, -2.5), Floor(length_m=4, width_m=6)) == pytest.approx(-0.5)
