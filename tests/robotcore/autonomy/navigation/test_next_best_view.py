from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.navigation.grid_search import UNREACHED
from robotcore.autonomy.navigation.mapping import Map
from robotcore.autonomy.navigation.next_best_view import (
    DOUBT,
    ELSEWHERE_M,
    GUESS_M,
    KEPT_GAIN,
    MIN_GAIN_M2,
    VIEW_M,
    Coverage,
    Viewpoint,
    _worths,
    best_viewpoint,
)
from robotcore.autonomy.navigation.occupancy_grid import CLOSE_M
from robotcore.geometry import Pose
from tests.robotcore.autonomy.navigation.places import HERE, REACH, take, veil


@pytest.fixture
def grid() -> OccupancyGrid:
    """Four metres by four, all of it known to be free."""
    grid = OccupancyGrid(size=4.0, cell=0.05)
    grid.evidence[:] = -1.0
    return grid


@pytest.fixture
def coverage(grid: OccupancyGrid) -> Coverage:
    return Coverage(grid)


def looked_at(grid: OccupancyGrid, coverage: Coverage, *points: tuple[float, float]) -> list[bool]:
    return [bool(coverage.looked_at[grid.cell_of(*point)]) for point in points]


def gain(grid: OccupancyGrid, coverage: Coverage, x: float = 0.0, y: float = 0.0) -> float:
    return float(coverage.gains(np.array([grid.cell_of(x, y)]))[0])


class TestView:
    def test_a_camera_looks_at_what_nothing_hides(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        take(grid, 0.5, 0.5, -0.5, 0.5)
        coverage.add_view(HERE, math.tau)
        points = [(-1.0, 0.0), (-0.3, 0.0), (0.3, 0.0), (0.6, 0.0), (1.0, 0.0)]
        assert looked_at(grid, coverage, *points) == [True, True, True, False, False]

    def test_it_looks_past_the_end_of_a_wall(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        take(grid, 0.5, 0.5, -0.5, 0.5)
        coverage.add_view(HERE, math.tau)
        assert looked_at(grid, coverage, (0.7, 1.2)) == [True]

    def test_what_is_not_known_to_be_free_is_not_taken_for_seen(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        veil(grid, 0.5, 0.6, -0.5, 0.5)
        coverage.add_view(HERE, math.tau)
        assert looked_at(grid, coverage, (0.4, 0.0), (0.55, 0.0), (0.8, 0.0)) == [True, False, False]

    def test_it_looks_only_where_it_is_turned_to(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.add_view(Pose(0.0, 0.0, math.pi / 2), math.radians(60))
        points = [(0.0, 1.0), (0.5, 1.0), (0.8, 1.0), (0.0, -1.0)]
        assert looked_at(grid, coverage, *points) == [True, True, False, False]

    def test_it_sees_no_farther_than_a_view_counts(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.add_view(Pose(-1.5, 0.0, 0.0), 1.0)
        assert looked_at(grid, coverage, (VIEW_M - 1.6, 0.0), (VIEW_M - 1.4, 0.0)) == [True, False]

    def test_what_it_sees_beyond_the_map_leaves_no_trace_at_the_border(
        self, grid: OccupancyGrid, coverage: Coverage
    ) -> None:
        coverage.add_view(Pose(2.5, 2.5, 0.8), math.radians(60))
        assert not coverage.looked_at.any()


class TestGains:
    def test_is_the_area_that_can_be_seen_and_was_not(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        assert gain(grid, coverage) == pytest.approx(math.pi * VIEW_M**2, rel=0.1)
        coverage.looked_at[:, grid.count // 2 :] = True
        assert gain(grid, coverage) == pytest.approx(math.pi * VIEW_M**2 / 2, rel=0.1)

    def test_walls_hide_what_is_behind(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.looked_at[:] = True
        coverage.looked_at[grid.disc(1.2, 0.0, 0.3)] = False
        assert gain(grid, coverage) > 0.2
        take(grid, 0.5, 0.5, -1.0, 1.0)
        assert gain(grid, coverage) == 0.0

    @pytest.mark.parametrize("thickness, is_seen", [(GUESS_M - 0.15, True), (GUESS_M + 0.15, False)])
    def test_of_the_unknown_a_little_may_be_passed(
        self, grid: OccupancyGrid, coverage: Coverage, thickness: float, is_seen: bool
    ) -> None:
        coverage.looked_at[:] = True
        coverage.looked_at[grid.disc(1.2, 0.0, 0.3)] = False
        veil(grid, 0.2, 0.2 + thickness, -1.0, 1.0)
        assert (gain(grid, coverage) > 0.2) is is_seen

    def test_past_a_near_doubtful_wall_it_counts_for_less(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.looked_at[:] = True
        coverage.looked_at[grid.disc(1.2, 0.0, 0.3)] = False
        open_gain = gain(grid, coverage)
        take(grid, CLOSE_M - 0.1, CLOSE_M - 0.1, -1.0, 1.0, heard_from=1.0)
        assert gain(grid, coverage) == pytest.approx(DOUBT * open_gain)

    def test_doubtful_walls_afar_hide_as_others_do(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.looked_at[:] = True
        coverage.looked_at[grid.disc(1.4, 0.0, 0.2)] = False
        take(grid, CLOSE_M + 0.2, CLOSE_M + 0.2, -1.0, 1.0, heard_from=1.0)
        assert gain(grid, coverage) == 0.0

    def test_there_is_nothing_to_see_beyond_the_map(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        assert gain(grid, coverage, 1.95, 1.95) == pytest.approx(gain(grid, coverage) / 4, rel=0.15)


class TestLookRound:
    def test_what_it_leaves_hidden_is_not_sought_from_there_again(
        self, grid: OccupancyGrid, coverage: Coverage
    ) -> None:
        veil(grid, 0.3, 0.5, -1.0, 1.0)
        take(grid, -0.5, -0.5, -1.0, 1.0, heard_from=1.0)
        before = gain(grid, coverage)
        coverage.add_look_round(0.0, 0.0)
        assert gain(grid, coverage) < 0.05 * before

    def test_what_a_wall_hides_stays_to_be_seen_from_elsewhere(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        take(grid, 0.5, 0.5, -1.0, 1.0)
        coverage.add_look_round(0.0, 0.0)
        assert looked_at(grid, coverage, (0.3, 0.0), (1.0, 0.0)) == [True, False]
        assert gain(grid, coverage, 1.0, 0.0) > 0.3


class TestUnseenBearings:
    def test_point_to_what_was_not_looked_at(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.looked_at[:] = True
        coverage.looked_at[grid.disc(0.0, 1.0, 0.4)] = False
        bearings = coverage.unseen_bearings(HERE)
        assert bearings.mean() == pytest.approx(math.pi / 2, abs=0.1)
        assert np.ptp(bearings) < 1.3

    def test_are_relative_to_the_heading(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.looked_at[:] = True
        coverage.looked_at[grid.disc(0.0, 1.0, 0.4)] = False
        bearings = coverage.unseen_bearings(Pose(0.0, 0.0, -math.pi / 2 + 0.5 + math.tau))
        assert ((bearings >= -math.pi) & (bearings < math.pi)).all()
        assert np.cos(bearings).max() < -0.2

    def test_a_speck_is_not_worth_turning_to(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.looked_at[:] = True
        coverage.looked_at[grid.disc(0.0, 1.0, 0.07)] = False
        assert not coverage.unseen_bearings(HERE).size


def view_from_here(field: Map) -> Viewpoint | None:
    return best_viewpoint(field.ground, field.coverage, field.grid.cell_of(0.0, 0.0))


def hide(field: Map, x: float, y: float, radius: float) -> None:
    field.coverage.looked_at[field.grid.disc(x, y, radius)] = False


def test_where_all_was_looked_at_there_is_no_view(field: Map) -> None:
    assert view_from_here(field) is None


def test_a_view_shows_what_was_not_looked_at(field: Map) -> None:
    take(field.grid, 0.5, 0.6, -1.0, 1.0)
    hide(field, 1.2, 0.0, 0.4)
    view = view_from_here(field)
    assert view
    assert view.way.path[-1] == view.place
    field.coverage.add_look_round(*field.grid.point_of(*view.place))
    assert field.coverage.looked_at[field.grid.disc(1.2, 0.0, 0.4)].mean() > 0.5


def test_of_two_views_the_nearer_is_taken(field: Map) -> None:
    take(field.grid, 0.5, 0.6, -0.5, 0.5)
    hide(field, 0.9, 0.0, 0.22)
    take(field.grid, -1.1, -1.0, -0.5, 0.5)
    hide(field, -1.4, 0.0, 0.25)
    view = view_from_here(field)
    assert view
    assert field.grid.point_of(*view.place)[0] > 0


def test_a_good_view_through_a_narrow_gap_is_worth_more_than_a_poor_one_beside(field: Map) -> None:
    take(field.grid, 0.5, 0.6, -2.0, -REACH - 0.09)
    take(field.grid, 0.5, 0.6, REACH + 0.09, 2.0)
    hide(field, 1.2, 0.9, 0.5)
    hide(field, 1.2, -0.9, 0.5)
    hide(field, -1.75, 0.0, 0.2)
    view = view_from_here(field)
    assert view
    assert field.grid.point_of(*view.place)[0] > 0.3


def test_what_can_be_seen_from_here_is_no_view_elsewhere(field: Map) -> None:
    hide(field, 0.0, 0.9, 0.1)
    assert view_from_here(field) is None


def test_a_place_beside_the_robot_is_not_elsewhere(field: Map) -> None:
    take(field.grid, 0.4, 0.5, -0.5, 0.5)
    take(field.grid, -0.5, -0.4, -0.5, 0.5)
    take(field.grid, -0.5, 0.5, 0.4, 0.5)
    take(field.grid, -0.5, 0.5, -0.5, -0.4)
    hide(field, 0.0, 0.0, ELSEWHERE_M)
    assert view_from_here(field) is None


def test_a_view_is_worth_going_to_until_it_has_been_seen(field: Map) -> None:
    take(field.grid, 0.5, 0.6, -1.0, 1.0)
    hide(field, 1.2, 0.0, 0.4)
    view = view_from_here(field)
    assert view
    assert view.is_worth_going(field.coverage)
    field.coverage.looked_at[:] = True
    assert not view.is_worth_going(field.coverage)


def test_where_no_way_leads_there_is_no_view() -> None:
    assert _worths(np.array([9.0, 9.0]), np.array([UNREACHED, 20]), 0.04).tolist() == [0.0, 9.0 / 2.0]


@pytest.mark.parametrize("radius", [0.25, 0.6])
def test_a_view_must_go_on_to_show_part_of_what_it_promised_and_never_next_to_nothing(
    field: Map, radius: float
) -> None:
    take(field.grid, 0.5, 0.6, -1.0, 1.0)
    hide(field, 1.2, 0.0, radius)
    view = view_from_here(field)
    assert view
    gain = float(field.coverage.gains(np.array([view.place]))[0])
    assert view.least_gain == pytest.approx(max(MIN_GAIN_M2, KEPT_GAIN * gain))
    assert (view.least_gain > MIN_GAIN_M2) is (radius > 0.5)
