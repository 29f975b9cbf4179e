from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.autonomy.navigation import Target
from robotcore.autonomy.navigation.grid_search import Cell
from robotcore.autonomy.navigation.mapping import Map
from robotcore.autonomy.navigation.occupancy_grid import OccupancyGrid
from robotcore.autonomy.navigation.planner import (
    BARRED_M,
    MARGINS_M,
    NO_PATH,
    NO_PATH_PLAN,
    RING_M,
    WORTH_M,
    Certainty,
    PathPlan,
    begins_known,
    is_unobstructed,
    plan_path,
    straight_starts,
)
from robotcore.geometry import Pose
from tests.robotcore.autonomy.navigation.places import HERE, REACH, take, veil


def cell(grid: OccupancyGrid, x: float, y: float = 0.0) -> Cell:
    return grid.cell_of(x, y)


def test_a_robot_keeps_its_reach_and_a_margin_from_things(field: Map) -> None:
    take(field.grid, 0.8, 1.0, -2.0, 2.0)
    near = field.grid.clearance()
    for margin, mask in zip(MARGINS_M, field.ground.open_cells(field.grid.cell_of(0.0, 0.0)), strict=True):
        assert near[mask].min() > REACH + margin
        assert mask[cell(field.grid, 0.8 - REACH - margin - 0.1)]


def test_a_robot_in_a_tight_place_may_step_out_but_not_onto_things(field: Map) -> None:
    take(field.grid, 0.05, 0.15, -0.3, 0.3)
    for mask in field.ground.open_cells(cell(field.grid, 0.0)):
        assert mask[cell(field.grid, 0.0)]
        assert mask[cell(field.grid, -0.06)]
        assert not mask[cell(field.grid, 0.06)]


def test_how_far_the_unknown_and_the_doubtful_are_trusted_can_be_chosen(field: Map) -> None:
    veil(field.grid, -1.2, -0.8, -0.4, 0.4)
    take(field.grid, 0.8, 1.0, -0.4, 0.4, heard_from=1.0)
    take(field.grid, -0.4, 0.4, 0.8, 1.0)
    places = [cell(field.grid, -1.0), cell(field.grid, 0.9), cell(field.grid, 0.0, 0.9)]
    here = cell(field.grid, 0.0)
    is_open = {trust: [bool(field.ground.open_cells(here, trust)[0][place]) for place in places] for trust in Certainty}
    assert is_open == {
        Certainty.KNOWN: [False, False, False],
        Certainty.UNKNOWN: [True, False, False],
        Certainty.DOUBTFUL: [True, True, False],
    }


def test_what_is_barred_is_closed_unless_it_is_known(field: Map) -> None:
    here, there = cell(field.grid, 0.0), cell(field.grid, 1.0)
    field.ground.bar(there)
    is_open = [bool(field.ground.open_cells(here, trust)[0][there]) for trust in Certainty]
    assert is_open == [True, False, False]


def test_a_way_leads_to_its_goal_with_the_widest_margin_that_there_is(field: Map) -> None:
    take(field.grid, 0.5, 0.6, -2.0, -REACH - 0.09)
    take(field.grid, 0.5, 0.6, REACH + 0.09, 2.0)
    here, there = cell(field.grid, 0.0), cell(field.grid, 1.0)
    way = field.ground.way_to(here, there)
    assert (way.path[0], way.path[-1]) == (here, there)
    assert field.grid.clearance()[way.open_cells].min() < REACH + MARGINS_M[0]
    assert all(way.open_cells[place] for place in way.path)


def test_there_is_no_way_through_a_wall(field: Map) -> None:
    take(field.grid, 0.5, 0.6, -2.0, 2.0)
    assert field.ground.way_to(field.grid.cell_of(HERE.x, HERE.y), cell(field.grid, 1.0)) is NO_PATH


BALL = Target(1.4, 0.0, 0.5)


class TestTarget:
    def test_a_gap_is_how_far_there_is_to_go(self) -> None:
        assert BALL.gap(HERE) == pytest.approx(0.9)
        assert BALL.gap(Pose(1.4, 0.4, 0.0)) == pytest.approx(-0.1)

    def test_a_bearing_is_seen_from_the_robot(self) -> None:
        assert BALL.bearing(Pose(1.4, -1.0, 0.0)) == pytest.approx(math.pi / 2)


class TestUnobstructed:
    def test_open_ground_is(self, field: Map) -> None:
        assert is_unobstructed(field.grid, HERE, BALL)

    def test_what_stands_between_is_in_the_way(self, field: Map) -> None:
        take(field.grid, 0.5, 0.6, -0.05, 0.05)
        assert not is_unobstructed(field.grid, HERE, BALL)

    def test_what_the_robot_would_brush_is_in_the_way(self, field: Map) -> None:
        take(field.grid, 0.5, 0.6, 0.07, 0.2)
        assert not is_unobstructed(field.grid, HERE, BALL)

    def test_what_it_would_pass_is_not(self, field: Map) -> None:
        take(field.grid, 0.5, 0.6, 0.2, 0.4)
        assert is_unobstructed(field.grid, HERE, BALL)

    def test_the_target_itself_is_not_in_the_way(self, field: Map) -> None:
        take(field.grid, 1.04, 1.5, -0.2, 0.2)
        assert is_unobstructed(field.grid, HERE, BALL)

    def test_a_target_may_lie_beyond_the_map(self, field: Map) -> None:
        assert is_unobstructed(field.grid, HERE, Target(9.0, 1.0, 0.5))
        take(field.grid, 0.5, 0.6, -0.2, 0.4)
        assert not is_unobstructed(field.grid, HERE, Target(9.0, 1.0, 0.5))


class TestBeginsKnown:
    def test_what_is_unknown_beside_the_robot_is_not(self, field: Map) -> None:
        assert begins_known(field.grid, HERE, BALL)
        veil(field.grid, 0.25, 0.35, 0.05, 0.2)
        assert not begins_known(field.grid, HERE, BALL)

    def test_what_is_unknown_farther_on_does_not_matter(self, field: Map) -> None:
        veil(field.grid, 0.7, 0.8, -0.2, 0.2)
        assert begins_known(field.grid, HERE, BALL)

    def test_the_target_itself_does_not_matter(self, field: Map) -> None:
        take(field.grid, 1.02, 1.5, -0.2, 0.2)
        assert begins_known(field.grid, Pose(0.55, 0.0, 0.0), BALL)

    def test_a_robot_that_is_there_need_know_nothing(self, field: Map) -> None:
        field.grid.evidence[:] = 0.0
        assert begins_known(field.grid, Pose(0.95, 0.0, 0.0), BALL)


class TestStraightStarts:
    def test_are_a_ring_before_the_place_to_stand(self, field: Map) -> None:
        cells = np.argwhere(straight_starts(field.grid, BALL)).tolist()
        away = [math.dist(field.grid.point_of(*cell), BALL[:2]) for cell in cells]
        assert min(away) == pytest.approx(BALL.distance + RING_M[0], abs=0.05)
        assert max(away) == pytest.approx(BALL.distance + RING_M[1], abs=0.05)

    def test_leave_out_what_something_stands_before(self, field: Map) -> None:
        take(field.grid, 0.9, 1.0, -0.5, 0.5)
        starts = straight_starts(field.grid, BALL)
        assert not starts[field.grid.cell_of(0.7, 0.0)]
        assert starts[field.grid.cell_of(1.4, 0.7)]

    def test_need_more_room_than_the_way_itself(self) -> None:
        grid = OccupancyGrid(size=4.0, cell=0.02)
        take(grid, 0.6, 0.9, 0.15, 0.3)
        here = Pose(0.62, 0.0, 0.0)
        assert is_unobstructed(grid, here, BALL)
        assert not straight_starts(grid, BALL)[grid.cell_of(here.x, here.y)]


def plan(field: Map, x: float, y: float = 0.0, *, is_surveyed: bool = False) -> PathPlan:
    goals = field.grid.disc(x, y, 0.1)
    return plan_path(field.ground, field.grid.cell_of(0.0, 0.0), goals, is_surveyed=is_surveyed)


def end(field: Map, detour: PathPlan) -> tuple[float, float]:
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
    assert (detour is not NO_PATH_PLAN) is is_tried


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
    assert plan(field, 1.3) is NO_PATH_PLAN
    assert NO_PATH_PLAN.bearing_on(HERE, field.ground) == 0.0
