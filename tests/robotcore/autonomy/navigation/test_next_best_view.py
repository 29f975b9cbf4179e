from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.navigation.grid_paths import UNREACHED
from robotcore.autonomy.navigation.mapping import NavigationMap
from robotcore.autonomy.navigation.next_best_view import (
    GAP_PROBABILITY,
    GUESS_M,
    MIN_GAIN_M2,
    MIN_GAIN_SHARE,
    MIN_VIEW_DISTANCE_M,
    VIEW_M,
    Coverage,
    Viewpoint,
    _compute_utilities,
    best_viewpoint,
)
from robotcore.autonomy.navigation.occupancy_grid import CLOSE_M
from robotcore.geometry import Pose
from tests.robotcore.autonomy.navigation.map_drawing import HERE, REACH, mark_occupied, mark_unknown


@pytest.fixture
def grid() -> OccupancyGrid:
    """Return a free map of 4 m × 4 m."""
    grid = OccupancyGrid(size=4.0, cell=0.05)
    grid.evidence[:] = -1.0
    return grid


@pytest.fixture
def coverage(grid: OccupancyGrid) -> Coverage:
    return Coverage(grid)


def are_seen(grid: OccupancyGrid, coverage: Coverage, *points: tuple[float, float]) -> list[bool]:
    return [bool(coverage.seen[grid.cell_of(*point)]) for point in points]


def measure_gain(grid: OccupancyGrid, coverage: Coverage, x: float = 0.0, y: float = 0.0) -> float:
    return float(coverage.gains(np.array([grid.cell_of(x, y)]))[0])


class TestView:
    def test_camera_sees_cells_that_nothing_hides(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        mark_occupied(grid, 0.5, 0.5, -0.5, 0.5)
        coverage.add_view(HERE, math.tau)
        points = [(-1.0, 0.0), (-0.3, 0.0), (0.3, 0.0), (0.6, 0.0), (1.0, 0.0)]
        assert are_seen(grid, coverage, *points) == [True, True, True, False, False]

    def test_unknown_cells_are_not_seen(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        mark_unknown(grid, 0.5, 0.6, -0.5, 0.5)
        coverage.add_view(HERE, math.tau)
        assert are_seen(grid, coverage, (0.4, 0.0), (0.55, 0.0), (0.8, 0.0)) == [True, False, False]

    def test_camera_sees_only_its_field_of_view(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.add_view(Pose(0.0, 0.0, math.pi / 2), math.radians(60))
        points = [(0.0, 1.0), (0.5, 1.0), (0.8, 1.0), (0.0, -1.0)]
        assert are_seen(grid, coverage, *points) == [True, True, False, False]

    def test_camera_sees_no_farther_than_the_limit(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.add_view(Pose(-1.5, 0.0, 0.0), 1.0)
        assert are_seen(grid, coverage, (VIEW_M - 1.6, 0.0), (VIEW_M - 1.4, 0.0)) == [True, False]

    def test_view_beyond_the_map_marks_no_border_cells(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.add_view(Pose(2.5, 2.5, 0.8), math.radians(60))
        assert not coverage.seen.any()


class TestGains:
    def test_gain_is_the_visible_unseen_area(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        assert measure_gain(grid, coverage) == pytest.approx(math.pi * VIEW_M**2, rel=0.1)
        coverage.seen[:, grid.count // 2 :] = True
        assert measure_gain(grid, coverage) == pytest.approx(math.pi * VIEW_M**2 / 2, rel=0.1)

    def test_walls_hide_cells_behind_them(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.seen[:] = ~grid.disc(1.2, 0.0, 0.3)
        assert measure_gain(grid, coverage) > 0.2
        mark_occupied(grid, 0.5, 0.5, -1.0, 1.0)
        assert measure_gain(grid, coverage) == 0.0

    @pytest.mark.parametrize("thickness, is_seen", [(GUESS_M - 0.15, True), (GUESS_M + 0.15, False)])
    def test_view_passes_a_little_unknown_area(
        self, grid: OccupancyGrid, coverage: Coverage, thickness: float, is_seen: bool
    ) -> None:
        coverage.seen[:] = ~grid.disc(1.2, 0.0, 0.3)
        mark_unknown(grid, 0.2, 0.2 + thickness, -1.0, 1.0)
        assert (measure_gain(grid, coverage) > 0.2) is is_seen

    def test_area_behind_a_near_uncertain_wall_counts_less(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.seen[:] = ~grid.disc(1.2, 0.0, 0.3)
        open_gain = measure_gain(grid, coverage)
        mark_occupied(grid, CLOSE_M - 0.1, CLOSE_M - 0.1, -1.0, 1.0, nearest_echo=1.0)
        assert measure_gain(grid, coverage) == pytest.approx(GAP_PROBABILITY * open_gain)

    def test_far_uncertain_walls_hide_cells(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.seen[:] = ~grid.disc(1.4, 0.0, 0.2)
        mark_occupied(grid, CLOSE_M + 0.2, CLOSE_M + 0.2, -1.0, 1.0, nearest_echo=1.0)
        assert measure_gain(grid, coverage) == 0.0

    def test_there_is_nothing_to_see_beyond_the_map(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        assert measure_gain(grid, coverage, 1.95, 1.95) == pytest.approx(measure_gain(grid, coverage) / 4, rel=0.15)


class TestLookRound:
    def test_area_hidden_from_a_point_has_no_gain_there_after_a_full_turn(
        self, grid: OccupancyGrid, coverage: Coverage
    ) -> None:
        mark_unknown(grid, 0.3, 0.5, -1.0, 1.0)
        mark_occupied(grid, -0.5, -0.5, -1.0, 1.0, nearest_echo=1.0)
        before = measure_gain(grid, coverage)
        coverage.add_full_turn(0.0, 0.0)
        assert measure_gain(grid, coverage) < 0.05 * before

    def test_area_behind_a_wall_stays_unseen_for_other_points(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        mark_occupied(grid, 0.5, 0.5, -1.0, 1.0)
        coverage.add_full_turn(0.0, 0.0)
        assert are_seen(grid, coverage, (0.3, 0.0), (1.0, 0.0)) == [True, False]
        assert measure_gain(grid, coverage, 1.0, 0.0) > 0.3


class TestUnseenBearings:
    def test_bearings_point_to_unseen_area(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.seen[:] = ~grid.disc(0.0, 1.0, 0.4)
        bearings = coverage.unseen_bearings(HERE)
        assert bearings.mean() == pytest.approx(math.pi / 2, abs=0.1)
        assert np.ptp(bearings) < 1.3

    def test_bearings_are_relative_to_the_heading(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.seen[:] = ~grid.disc(0.0, 1.0, 0.4)
        bearings = coverage.unseen_bearings(Pose(0.0, 0.0, -math.pi / 2 + 0.5 + math.tau))
        assert ((bearings >= -math.pi) & (bearings < math.pi)).all()
        assert np.cos(bearings).max() < -0.2

    def test_tiny_area_has_no_bearing(self, grid: OccupancyGrid, coverage: Coverage) -> None:
        coverage.seen[:] = ~grid.disc(0.0, 1.0, 0.07)
        assert not coverage.unseen_bearings(HERE).size


def view_from_here(field: NavigationMap) -> Viewpoint | None:
    return best_viewpoint(field.ground, field.coverage, field.grid.cell_of(0.0, 0.0))


def mark_unseen(field: NavigationMap, x: float, y: float, radius: float) -> None:
    field.coverage.seen[field.grid.disc(x, y, radius)] = False


def test_there_is_no_view_if_all_cells_are_seen(field: NavigationMap) -> None:
    assert view_from_here(field) is None


def test_view_shows_unseen_area(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.5, 0.6, -1.0, 1.0)
    mark_unseen(field, 1.2, 0.0, 0.4)
    view = view_from_here(field)
    assert view
    assert view.path.cells[-1] == view.place
    field.coverage.add_full_turn(*field.grid.point_of(*view.place))
    assert field.coverage.seen[field.grid.disc(1.2, 0.0, 0.4)].mean() > 0.5


def test_nearer_of_two_equal_views_is_best(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.5, 0.6, -0.5, 0.5)
    mark_unseen(field, 0.9, 0.0, 0.22)
    mark_occupied(field.grid, -1.1, -1.0, -0.5, 0.5)
    mark_unseen(field, -1.4, 0.0, 0.25)
    view = view_from_here(field)
    assert view
    assert field.grid.point_of(*view.place)[0] > 0


def test_a_good_view_through_a_narrow_gap_is_worth_more_than_a_poor_one_beside(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.5, 0.6, -2.0, -REACH - 0.09)
    mark_occupied(field.grid, 0.5, 0.6, REACH + 0.09, 2.0)
    mark_unseen(field, 1.2, 0.9, 0.5)
    mark_unseen(field, 1.2, -0.9, 0.5)
    mark_unseen(field, -1.75, 0.0, 0.2)
    view = view_from_here(field)
    assert view
    assert field.grid.point_of(*view.place)[0] > 0.3


def test_cell_beside_the_robot_is_no_view(field: NavigationMap) -> None:
    mark_occupied(field.grid, 0.4, 0.5, -0.5, 0.5)
    mark_occupied(field.grid, -0.5, -0.4, -0.5, 0.5)
    mark_occupied(field.grid, -0.5, 0.5, 0.4, 0.5)
    mark_occupied(field.grid, -0.5, 0.5, -0.5, -0.4)
    mark_unseen(field, 0.0, 0.0, MIN_VIEW_DISTANCE_M)
    assert view_from_here(field) is None


def test_there_is_no_view_without_a_path() -> None:
    assert _compute_utilities(np.array([9.0, 9.0]), np.array([UNREACHED, 20]), 0.04).tolist() == [0.0, 9.0 / 2.0]


@pytest.mark.parametrize("radius", [0.25, 0.6])
def test_view_is_given_up_below_its_least_gain(field: NavigationMap, radius: float) -> None:
    mark_occupied(field.grid, 0.5, 0.6, -1.0, 1.0)
    mark_unseen(field, 1.2, 0.0, radius)
    view = view_from_here(field)
    assert view
    measure_gain = float(field.coverage.gains(np.array([view.place]))[0])
    assert view.least_gain == pytest.approx(max(MIN_GAIN_M2, MIN_GAIN_SHARE * measure_gain))
    assert (view.least_gain > MIN_GAIN_M2) is (radius > 0.5)
