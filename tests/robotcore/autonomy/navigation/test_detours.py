from __future__ import annotations

import math

import pytest

from robotcore.autonomy.navigation.detours import NO_DETOUR, WORTH_M, Detour, plan_detour
from robotcore.autonomy.navigation.ground import BARRED_M
from robotcore.autonomy.navigation.mapping import Map
from tests.robotcore.autonomy.navigation.places import HERE, take, veil


def plan(field: Map, x: float, y: float = 0.0, *, is_surveyed: bool = False) -> Detour:
    goals = field.grid.disc(x, y, 0.1)
    return plan_detour(field.ground, field.grid.cell_of(0.0, 0.0), goals, is_surveyed=is_surveyed)


def end(field: Map, detour: Detour) -> tuple[float, float]:
    return field.grid.point_of(*detour.way.path[-1])


def test_a_known_way_leads_all_the_way(field: Map) -> None:
    detour = plan(field, 1.2)
    assert math.dist(end(field, detour), (1.2, 0.0)) < 0.15
    assert not detour.beyond


def test_a_way_ends_where_it_leaves_what_is_known(field: Map) -> None:
    veil(field.grid, 0.8, 2.0, -2.0, 2.0)
    detour = plan(field, 1.4)
    assert 0.4 < end(field, detour)[0] < 0.8
    assert math.dist(field.grid.point_of(*detour.beyond[-1]), (1.4, 0.0)) < 0.15


def test_a_short_way_through_the_unknown_beats_a_long_one_that_is_known(field: Map) -> None:
    take(field.grid, 0.7, 0.8, -1.7, 0.0)
    veil(field.grid, 0.6, 0.9, 0.0, 0.8)
    take(field.grid, 0.7, 0.8, 0.9, 1.2)
    assert plan(field, 1.3).beyond


def test_a_known_way_beats_one_through_the_unknown_that_is_not_much_shorter(field: Map) -> None:
    veil(field.grid, 0.5, 0.9, -0.1, 0.1)
    assert not plan(field, 1.3).beyond


@pytest.mark.parametrize("heard_from, is_tried", [(1.0, True), (0.3, False)])
def test_a_wall_that_was_only_heard_from_afar_may_be_a_gap(field: Map, heard_from: float, is_tried: bool) -> None:
    take(field.grid, 0.8, 0.9, -5.99, 5.99, heard_from)
    detour = plan(field, 1.3)
    assert (detour is not NO_DETOUR) is is_tried


def test_where_too_little_is_known_what_is_beyond_is_to_be_surveyed(field: Map) -> None:
    veil(field.grid, 0.3, 2.0, -2.0, 2.0)
    take(field.grid, -0.5, 0.3, 0.5, 0.6)
    take(field.grid, -0.5, 0.3, -0.6, -0.5)
    take(field.grid, -0.6, -0.5, -0.6, 0.6)
    detour = plan(field, 1.3)
    assert not detour.way.path
    assert detour.bearing_on(HERE, field.ground) == pytest.approx(0.0, abs=0.5)


def test_what_a_survey_did_not_open_is_barred_and_the_next_way_is_tried(field: Map) -> None:
    take(field.grid, 0.7, 0.8, -1.8, 1.8)
    veil(field.grid, 0.3, 1.1, -0.3, 0.3)
    veil(field.grid, 0.6, 0.9, 1.1, 1.6)
    closed = field.grid.point_of(*plan(field, 1.3).beyond[0])
    other = plan(field, 1.3, is_surveyed=True)
    assert len(other.way.path) * field.grid.cell > WORTH_M
    assert all(math.dist(field.grid.point_of(*cell), closed) > BARRED_M for cell in other.beyond)


def test_where_nothing_leads_there_is_no_detour(field: Map) -> None:
    take(field.grid, 0.7, 0.8, -5.99, 5.99)
    assert plan(field, 1.3) is NO_DETOUR
    assert NO_DETOUR.bearing_on(HERE, field.ground) == 0.0
