from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.autonomy.navigation import StopPoint
from robotcore.autonomy.navigation.grid_paths import Cell
from robotcore.autonomy.navigation.mapping import NavigationMap
from robotcore.autonomy.navigation.occupancy_grid import OccupancyGrid
from robotcore.autonomy.navigation.planner import (
    EXCLUDED_RADIUS_M,
    MARGINS_M,
    MIN_FREE_PATH_M,
    NO_PATH,
    NO_PATH_PLAN,
    RING_M,
    Certainty,
    PathPlan,
    find_straight_starts,
    is_start_known,
    is_unobstructed,
    plan_path,
)
from robotcore.geometry import Pose
from tests.robotcore.autonomy.navigation.map_drawing import HERE, REACH, mark_occupied, mark_unknown


def cell(grid: OccupancyGrid, x: float, y: float = 0.0) -> Cell:
    return grid.cell_of(x, y)


def test_open_cells_keep_reach_and_margin_from_bodies(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.8, 1.0, -2.0, 2.0)
    near = field.grid.clearance()
    for margin, mask in zip(MARGINS_M, field.ground.open_cells(field.grid.cell_of(0.0, 0.0)), strict=True):
        assert near[mask].min() > REACH + margin
        assert mask[cell(field.grid, 0.8 - REACH - margin - 0.1)]


def test_robot_in_a_narrow_place_may_leave_it(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.05, 0.15, -0.3, 0.3)
    for mask in field.ground.open_cells(cell(field.grid, 0.0)):
        assert mask[cell(field.grid, 0.0)]
        assert mask[cell(field.grid, -0.06)]
        assert not mask[cell(field.grid, 0.06)]


def test_unknown_and_uncertain_cells_can_be_open(field: NavigationMap) -> None:
    mark_unknown(field.grid, -1.2, -0.8, -0.4, 0.4)
    mark_occupied(field.grid, 0.8, 1.0, -0.4, 0.4, nearest_echo=1.0)
    mark_occupied(field.grid, -0.4, 0.4, 0.8, 1.0)
    places = [cell(field.grid, -1.0), cell(field.grid, 0.9), cell(field.grid, 0.0, 0.9)]
    here = cell(field.grid, 0.0)
    is_open = {trust: [bool(field.ground.open_cells(here, trust)[0][place]) for place in places] for trust in Certainty}
    assert is_open == {
        Certainty.KNOWN: [False, False, False],
        Certainty.UNKNOWN: [True, False, False],
        Certainty.DOUBTFUL: [True, True, False],
    }


def test_barred_cells_are_closed_for_uncertain_paths_only(field: NavigationMap) -> None:
    here, there = cell(field.grid, 0.0), cell(field.grid, 1.0)
    field.ground.bar(there)
    is_open = [bool(field.ground.open_cells(here, trust)[0][there]) for trust in Certainty]
    assert is_open == [True, False, False]


def test_path_leads_to_its_goal_with_the_widest_margin(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.5, 0.6, -2.0, -REACH - 0.09)
    mark_occupied(field.grid, 0.5, 0.6, REACH + 0.09, 2.0)
    here, there = cell(field.grid, 0.0), cell(field.grid, 1.0)
    way = field.ground.find_path(here, there)
    assert (way.cells[0], way.cells[-1]) == (here, there)
    assert field.grid.clearance()[way.open_cells].min() < REACH + MARGINS_M[0]
    assert all(way.open_cells[place] for place in way.cells)


def test_there_is_no_path_through_a_wall(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.5, 0.6, -2.0, 2.0)
    assert field.ground.find_path(field.grid.cell_of(HERE.x, HERE.y), cell(field.grid, 1.0)) is NO_PATH


BALL = StopPoint(1.4, 0.0, 0.5)


@pytest.mark.parametrize(
    "left, right, bottom, top, is_free",
    [
        pytest.param(0.5, 0.6, -0.05, 0.05, False, id="between"),
        pytest.param(0.5, 0.6, 0.07, 0.2, False, id="touched-by-the-robot"),
        pytest.param(0.5, 0.6, 0.2, 0.4, True, id="beside"),
        pytest.param(1.04, 1.5, -0.2, 0.2, True, id="the-target"),
    ],
)
def test_a_body_in_the_corridor_blocks_a_straight_path(
    field: NavigationMap, left: float, right: float, bottom: float, top: float, *, is_free: bool
) -> None:
    mark_occupied(field.grid, left, right, bottom, top)
    assert is_unobstructed(field.grid, HERE, BALL) is is_free


def test_a_target_may_lie_beyond_the_map(field: NavigationMap) -> None:
    assert is_unobstructed(field.grid, HERE, StopPoint(9.0, 1.0, 0.5))
    mark_occupied(field.grid, 0.5, 0.6, -0.2, 0.4)
    assert not is_unobstructed(field.grid, HERE, StopPoint(9.0, 1.0, 0.5))


@pytest.mark.parametrize("left, bottom, is_known", [(0.25, 0.05, False), (0.7, -0.2, True)])
def test_only_near_unknown_cells_make_a_start_unknown(
    field: NavigationMap, left: float, bottom: float, *, is_known: bool
) -> None:
    mark_unknown(field.grid, left, left + 0.1, bottom, 0.2)
    assert is_start_known(field.grid, HERE, BALL) is is_known


def test_start_at_the_target_is_known(field: NavigationMap) -> None:
    field.grid.evidence[:] = 0.0
    assert is_start_known(field.grid, Pose(0.95, 0.0, 0.0), BALL)
    mark_occupied(field.grid, 1.02, 1.5, -0.2, 0.2)
    mark_unknown(field.grid, 1.02, 1.5, -0.2, 0.2)
    assert is_start_known(field.grid, Pose(0.95, 0.0, 0.0), BALL)


class TestStraightStarts:
    def test_starts_form_a_ring_round_the_target(self, field: NavigationMap) -> None:
        cells = np.argwhere(find_straight_starts(field.grid, BALL)).tolist()
        away = [math.dist(field.grid.point_of(*cell), BALL[:2]) for cell in cells]
        assert min(away) == pytest.approx(BALL.distance + RING_M[0], abs=0.05)
        assert max(away) == pytest.approx(BALL.distance + RING_M[1], abs=0.05)

    def test_starts_exclude_cells_behind_a_body(self, field: NavigationMap) -> None:
        mark_occupied(field.grid, 0.9, 1.0, -0.5, 0.5)
        starts = find_straight_starts(field.grid, BALL)
        assert not starts[field.grid.cell_of(0.7, 0.0)]
        assert starts[field.grid.cell_of(1.4, 0.7)]

    def test_starts_need_more_room_than_the_path(self) -> None:
        grid = OccupancyGrid(size=4.0, cell=0.02)
        mark_occupied(grid, 0.6, 0.9, 0.15, 0.3)
        here = Pose(0.62, 0.0, 0.0)
        assert is_unobstructed(grid, here, BALL)
        assert not find_straight_starts(grid, BALL)[grid.cell_of(here.x, here.y)]


def plan(field: NavigationMap, x: float, y: float = 0.0, *, is_surveyed: bool = False) -> PathPlan:
    goals = field.grid.disc(x, y, 0.1)
    return plan_path(field.ground, field.grid.cell_of(0.0, 0.0), goals, is_surveyed=is_surveyed)


def end(field: NavigationMap, detour: PathPlan) -> tuple[float, float]:
    return field.grid.point_of(*detour.path.cells[-1])


def test_known_path_has_no_unknown_part(field: NavigationMap) -> None:
    detour = plan(field, 1.2)
    assert math.dist(end(field, detour), (1.2, 0.0)) < 0.15
    assert not detour.unknown_part


def test_path_ends_at_the_first_unknown_cell(field: NavigationMap) -> None:
    mark_unknown(field.grid, 0.8, 2.0, -2.0, 2.0)
    detour = plan(field, 1.4)
    assert 0.4 < end(field, detour)[0] < 0.8
    assert math.dist(field.grid.point_of(*detour.unknown_part[-1]), (1.4, 0.0)) < 0.15


def test_short_unknown_path_beats_a_long_known_one(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.7, 0.8, -1.7, 0.0)
    mark_unknown(field.grid, 0.6, 0.9, 0.0, 0.8)
    mark_occupied(field.grid, 0.7, 0.8, 0.9, 1.2)
    assert plan(field, 1.3).unknown_part


def test_known_path_beats_a_slightly_shorter_unknown_one(field: NavigationMap) -> None:
    mark_unknown(field.grid, 0.5, 0.9, -0.1, 0.1)
    assert not plan(field, 1.3).unknown_part


@pytest.mark.parametrize("nearest_echo, is_tried", [(1.0, True), (0.3, False)])
def test_uncertain_wall_may_be_a_gap(field: NavigationMap, nearest_echo: float, is_tried: bool) -> None:
    mark_occupied(field.grid, 0.8, 0.9, -5.99, 5.99, nearest_echo)
    detour = plan(field, 1.3)
    assert (detour is not NO_PATH_PLAN) is is_tried


def test_path_with_a_short_known_part_asks_for_a_survey(field: NavigationMap) -> None:
    mark_unknown(field.grid, 0.3, 2.0, -2.0, 2.0)
    mark_occupied(field.grid, -0.5, 0.3, 0.5, 0.6)
    mark_occupied(field.grid, -0.5, 0.3, -0.6, -0.5)
    mark_occupied(field.grid, -0.6, -0.5, -0.6, 0.6)
    detour = plan(field, 1.3)
    assert not detour.path.cells
    assert detour.compute_unknown_bearing(HERE, field.ground) == pytest.approx(0.0, abs=0.5)


def test_unknown_part_is_barred_after_a_survey(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.7, 0.8, -1.8, 1.8)
    mark_unknown(field.grid, 0.3, 1.1, -0.3, 0.3)
    mark_unknown(field.grid, 0.6, 0.9, 1.1, 1.6)
    closed = field.grid.point_of(*plan(field, 1.3).unknown_part[0])
    other = plan(field, 1.3, is_surveyed=True)
    assert len(other.path.cells) * field.grid.cell > MIN_FREE_PATH_M
    assert all(math.dist(field.grid.point_of(*cell), closed) > EXCLUDED_RADIUS_M for cell in other.unknown_part)


def test_there_is_no_plan_without_a_path(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.7, 0.8, -5.99, 5.99)
    assert plan(field, 1.3) is NO_PATH_PLAN
    assert NO_PATH_PLAN.compute_unknown_bearing(HERE, field.ground) == 0.0
