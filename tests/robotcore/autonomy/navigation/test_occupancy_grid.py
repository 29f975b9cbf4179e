from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.autonomy.navigation import OccupancyGrid
from robotcore.autonomy.navigation.occupancy_grid import CLOSE_M, EVIDENCE_LIMIT
from robotcore.geometry import Pose

CONE = math.radians(30)
ORIGIN = Pose(0.0, 0.0, 0.0)


@pytest.fixture
def grid() -> OccupancyGrid:
    return OccupancyGrid(size=4.0, cell=0.05)


def is_free(grid: OccupancyGrid, x: float, y: float) -> bool:
    return bool(grid.free[grid.cell_of(x, y)])


def is_taken(grid: OccupancyGrid, x: float, y: float) -> bool:
    return bool(grid.occupied[grid.cell_of(x, y)])


class TestCells:
    @given(st.floats(-1.99, 1.99), st.floats(-1.99, 1.99))
    def test_a_point_lies_in_its_cell(self, x: float, y: float) -> None:
        grid = OccupancyGrid(size=4.0, cell=0.05)
        middle = grid.point_of(*grid.cell_of(x, y))
        assert abs(middle[0] - x) <= 0.025 + 1e-9
        assert abs(middle[1] - y) <= 0.025 + 1e-9

    def test_rows_grow_with_y_and_columns_with_x(self, grid: OccupancyGrid) -> None:
        row, column = grid.cell_of(0.01, 0.01)
        assert grid.cell_of(0.01, 0.51) == (row + 10, column)
        assert grid.cell_of(0.51, 0.01) == (row, column + 10)

    def test_point_outside_the_map_has_a_cell_outside(self, grid: OccupancyGrid) -> None:
        assert grid.cell_of(2.01, -2.01) == (-1, grid.count)
        assert grid.cell_of(-2.01, 2.01) == (grid.count, -1)

    def test_map_with_another_centre_keeps_the_lattice(self) -> None:
        here, there = OccupancyGrid(4.0, 0.05), OccupancyGrid(4.0, 0.05, centre=(3.01, -1.0))
        row, column = here.cell_of(1.5, -0.5)
        assert there.cell_of(1.5, -0.5) == (row + 20, column - 60)
        assert there.point_of(*there.cell_of(1.5, -0.5)) == pytest.approx(here.point_of(row, column))

    @pytest.mark.parametrize(
        "x, y, margin, is_within",
        [
            (1.9, 0.0, 0.05, True),
            (1.9, 0.0, 0.2, False),
            (0.0, -1.9, 0.2, False),
            (2.1, 0.0, 0.0, False),
        ],
    )
    def test_is_within_checks_the_margin(
        self, grid: OccupancyGrid, x: float, y: float, margin: float, is_within: bool
    ) -> None:
        assert grid.is_within(x, y, margin) is is_within


class TestRange:
    def test_cells_before_an_echo_are_free_and_at_it_taken(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, 1.0, 2.0, CONE)
        assert is_free(grid, 0.5, 0.0)
        assert is_free(grid, 0.5, 0.1)
        assert is_taken(grid, 1.0, 0.0)
        assert is_taken(grid, math.cos(0.2), math.sin(0.2))

    def test_cells_outside_the_cone_stay_unknown(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, 1.0, 2.0, CONE)
        for x, y in ((1.3, 0.0), (-0.5, 0.0), (0.5, 0.3), (0.5, -0.3)):
            assert grid.evidence[grid.cell_of(x, y)] == 0

    def test_reading_without_an_echo_frees_the_whole_cone(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, math.inf, 1.5, CONE)
        assert is_free(grid, 1.4, 0.0)
        assert not grid.occupied.any()

    def test_the_cone_turns_and_moves_with_the_sensor(self, grid: OccupancyGrid) -> None:
        grid.add_range(Pose(0.5, -1.0, math.pi / 2), 1.0, 2.0, CONE)
        assert is_free(grid, 0.5, -0.5)
        assert is_taken(grid, 0.5, 0.0)
        assert not is_free(grid, 1.0, -1.0)

    def test_free_weighs_more_than_taken(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, 1.0, 2.0, CONE)
        grid.add_range(ORIGIN, math.inf, 1.5, CONE)
        assert is_free(grid, 1.0, 0.0)

    @pytest.mark.parametrize("noise, has_wall", [(0.0, False), (0.03, True)])
    def test_an_echo_frees_no_cells_that_may_have_caused_it(
        self, grid: OccupancyGrid, noise: float, has_wall: bool
    ) -> None:
        grid.add_range(ORIGIN, 1.0, 2.0, CONE, noise)
        grid.add_range(ORIGIN, 1.07, 2.0, CONE, noise)
        assert is_taken(grid, 1.0, 0.0) is has_wall
        assert is_free(grid, 0.9, 0.0)

    def test_map_follows_a_world_that_changes(self, grid: OccupancyGrid) -> None:
        for _ in range(1000):
            grid.add_range(ORIGIN, math.inf, 1.5, CONE)
        assert np.abs(grid.evidence).max() == EVIDENCE_LIMIT
        for _ in range(9):
            grid.add_range(ORIGIN, 1.0, 1.5, CONE)
        assert is_taken(grid, 1.0, 0.0)

    def test_a_cone_that_reaches_beyond_the_map_is_cut_off(self, grid: OccupancyGrid) -> None:
        grid.add_range(Pose(1.9, 1.9, 0.8), math.inf, 2.0, CONE)
        assert is_free(grid, 1.96, 1.96)
        grid.add_range(Pose(0.0, 1.5, math.pi / 2), 1.0, 2.0, CONE)
        assert not grid.occupied.any()

    @pytest.mark.parametrize("heading", [0.0, 1.0, 2.0, 4.0])
    def test_reading_from_outside_the_map_changes_no_border_cells(self, grid: OccupancyGrid, heading: float) -> None:
        grid.add_range(Pose(-9.0, 9.0, heading), 1.0, 2.0, CONE)
        grid.add_free_disc(9.0, 0.0, 0.3, certain=0.3)
        assert not grid.evidence.any()

    def test_echo_of_a_mapped_body_adds_nothing_beside_it(self, grid: OccupancyGrid) -> None:
        post = grid.cell_of(1.0, 0.0)
        grid.evidence[post] = 1.0
        grid.add_range(ORIGIN, 1.0, 2.0, CONE)
        assert grid.evidence[post] == 1.5
        assert grid.occupied.sum() == 1

    def test_echo_from_another_distance_adds_cells(self, grid: OccupancyGrid) -> None:
        grid.evidence[grid.cell_of(1.0, 0.0)] = 1.0
        grid.add_range(ORIGIN, 0.7, 2.0, CONE)
        assert is_taken(grid, 0.7 * math.cos(0.2), 0.7 * math.sin(0.2))


class TestDoubt:
    def test_far_echo_is_uncertain_until_a_near_one(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, 1.0, 2.0, CONE)
        assert (grid.uncertain == grid.occupied).all()
        grid.add_range(Pose(0.6, 0.0, 0.0), 0.4, 2.0, CONE)
        assert not grid.uncertain[grid.cell_of(1.0, 0.0)]

    def test_near_echo_is_certain_and_stays_so(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, CLOSE_M - 0.1, 2.0, CONE)
        grid.add_range(Pose(-0.5, 0.0, 0.0), CLOSE_M + 0.4, 2.0, CONE)
        assert grid.occupied.any()
        assert not grid.uncertain.any()


class TestFreeDisc:
    def test_cells_under_the_robot_are_free(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, 0.2, 2.0, CONE)
        grid.add_free_disc(0.0, 0.0, 0.3, certain=0.3)
        assert grid.evidence[grid.cell_of(0.2, 0.0)] == -EVIDENCE_LIMIT
        assert grid.evidence[grid.cell_of(0.35, 0.0)] == 0
        assert grid.free.sum() == pytest.approx(math.pi * 0.3**2 / 0.05**2, rel=0.1)
        assert (grid.free == grid.disc(0.0, 0.0, 0.3)).all()

    def test_occupied_cells_beside_the_body_stay(self, grid: OccupancyGrid) -> None:
        for x in (0.1, 0.25):
            grid.evidence[grid.cell_of(x, 0.0)] = 1.0
        grid.add_free_disc(0.0, 0.0, 0.3, certain=0.15)
        assert is_free(grid, 0.1, 0.0)
        assert is_taken(grid, 0.25, 0.0)
        assert is_free(grid, 0.0, 0.25)


class TestClearance:
    def test_clearance_is_the_distance_to_occupied_or_unknown_cells(self, grid: OccupancyGrid) -> None:
        grid.add_free_disc(0.0, 0.0, 0.5, certain=0.5)
        clearance = grid.clearance()
        assert clearance[grid.cell_of(0.0, 0.0)] == pytest.approx(0.5, abs=0.06)
        assert clearance[grid.cell_of(0.3, 0.0)] == pytest.approx(0.2, abs=0.06)
        assert clearance[grid.cell_of(1.0, 0.0)] == 0

    def test_clearance_can_ignore_unknown_cells(self, grid: OccupancyGrid) -> None:
        grid.evidence[grid.cell_of(1.0, 0.0)] = 1.0
        assert grid.clearance(with_unknown=False)[grid.cell_of(0.0, 0.0)] == pytest.approx(1.0, abs=0.06)

    def test_gap_between_two_rays_is_filled_but_occupied_cells_stay(self, grid: OccupancyGrid) -> None:
        grid.evidence[:] = -1.0
        grid.evidence[40, 10:30] = 0.0
        assert grid.clearance()[40, 20] > 0.2
        grid.evidence[40, 20] = 1.0
        assert grid.clearance()[40, 20] == 0.0

    def test_overlooked_cells_count_as_free(self, grid: OccupancyGrid) -> None:
        grid.evidence[grid.cell_of(0.5, 0.0)] = 1.0
        overlook = grid.disc(0.5, 0.0, 0.1)
        clearance = grid.clearance(with_unknown=False, overlook=overlook)
        assert clearance[grid.cell_of(0.5, 0.0)] > 0.5
