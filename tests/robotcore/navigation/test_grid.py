from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.geometry import Pose
from robotcore.navigation import OccupancyGrid
from robotcore.navigation.grid import CERTAIN

CONE = math.radians(30)
ORIGIN = Pose(0.0, 0.0, 0.0)


@pytest.fixture
def grid() -> OccupancyGrid:
    return OccupancyGrid(size=4.0, cell=0.05)


def is_free(grid: OccupancyGrid, x: float, y: float) -> bool:
    return bool(grid.free[grid.cell_of(x, y)])


def is_taken(grid: OccupancyGrid, x: float, y: float) -> bool:
    return bool(grid.taken[grid.cell_of(x, y)])


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

    def test_what_lies_outside_counts_as_at_the_border(self, grid: OccupancyGrid) -> None:
        assert grid.cell_of(-99.0, 99.0) == (grid.count - 1, 0)


class TestRange:
    def test_everything_nearer_is_free_and_what_is_there_is_taken(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, 1.0, 2.0, CONE)
        assert is_free(grid, 0.5, 0.0)
        assert is_free(grid, 0.5, 0.1)
        assert is_taken(grid, 1.0, 0.0)
        assert is_taken(grid, math.cos(0.2), math.sin(0.2))

    def test_nothing_is_learnt_of_what_is_behind_or_beside(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, 1.0, 2.0, CONE)
        for x, y in ((1.3, 0.0), (-0.5, 0.0), (0.5, 0.3), (0.5, -0.3)):
            assert grid.evidence[grid.cell_of(x, y)] == 0

    def test_no_echo_frees_the_cone_and_takes_nothing(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, math.inf, 1.5, CONE)
        assert is_free(grid, 1.4, 0.0)
        assert not grid.taken.any()

    def test_the_cone_turns_and_moves_with_the_sensor(self, grid: OccupancyGrid) -> None:
        grid.add_range(Pose(0.5, -1.0, math.pi / 2), 1.0, 2.0, CONE)
        assert is_free(grid, 0.5, -0.5)
        assert is_taken(grid, 0.5, 0.0)
        assert not is_free(grid, 1.0, -1.0)

    def test_free_weighs_more_than_taken(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, 1.0, 2.0, CONE)
        grid.add_range(ORIGIN, math.inf, 1.5, CONE)
        assert is_free(grid, 1.0, 0.0)

    def test_a_world_that_changes_can_be_learnt_again(self, grid: OccupancyGrid) -> None:
        for _ in range(1000):
            grid.add_range(ORIGIN, math.inf, 1.5, CONE)
        assert np.abs(grid.evidence).max() == CERTAIN
        for _ in range(9):
            grid.add_range(ORIGIN, 1.0, 1.5, CONE)
        assert is_taken(grid, 1.0, 0.0)

    def test_a_cone_that_reaches_beyond_the_map_is_cut_off(self, grid: OccupancyGrid) -> None:
        grid.add_range(Pose(1.9, 1.9, 0.8), math.inf, 2.0, CONE)
        assert is_free(grid, 1.96, 1.96)


class TestFreeDisc:
    def test_where_the_robot_stands_is_free_for_certain(self, grid: OccupancyGrid) -> None:
        grid.add_range(ORIGIN, 0.2, 2.0, CONE)
        grid.add_free_disc(0.0, 0.0, 0.3)
        assert grid.evidence[grid.cell_of(0.2, 0.0)] == -CERTAIN
        assert grid.evidence[grid.cell_of(0.35, 0.0)] == 0
        assert grid.free.sum() == pytest.approx(math.pi * 0.3**2 / 0.05**2, rel=0.1)
        assert (grid.free == grid.disc(0.0, 0.0, 0.3)).all()


class TestClearance:
    def test_is_the_distance_to_what_is_taken_or_unknown(self, grid: OccupancyGrid) -> None:
        grid.add_free_disc(0.0, 0.0, 0.5)
        clearance = grid.clearance()
        assert clearance[grid.cell_of(0.0, 0.0)] == pytest.approx(0.5, abs=0.06)
        assert clearance[grid.cell_of(0.3, 0.0)] == pytest.approx(0.2, abs=0.06)
        assert clearance[grid.cell_of(1.0, 0.0)] == 0

    def test_the_unknown_can_be_left_out(self, grid: OccupancyGrid) -> None:
        grid.evidence[grid.cell_of(1.0, 0.0)] = 1.0
        assert grid.clearance(with_unknown=False)[grid.cell_of(0.0, 0.0)] == pytest.approx(1.0, abs=0.06)

    def test_a_chink_between_two_rays_is_filled_but_what_is_taken_stays(self, grid: OccupancyGrid) -> None:
        grid.evidence[:] = -1.0
        grid.evidence[40, 10:30] = 0.0
        assert grid.clearance()[40, 20] > 0.2
        grid.evidence[40, 20] = 1.0
        assert grid.clearance()[40, 20] == 0.0

    def test_what_is_overlooked_counts_as_free(self, grid: OccupancyGrid) -> None:
        grid.evidence[grid.cell_of(0.5, 0.0)] = 1.0
        overlook = grid.disc(0.5, 0.0, 0.1)
        clearance = grid.clearance(with_unknown=False, overlook=overlook)
        assert clearance[grid.cell_of(0.5, 0.0)] > 0.5


class TestView:
    def wall(self, grid: OccupancyGrid) -> None:
        """Build a wall at x = 0.5 from y = -0.5 to 0.5."""
        for y in np.arange(-0.5, 0.5, grid.cell):
            grid.evidence[grid.cell_of(0.5, y)] = 1.0

    def test_a_camera_looks_at_what_nothing_hides(self, grid: OccupancyGrid) -> None:
        self.wall(grid)
        grid.add_view(ORIGIN, math.tau)
        looked_at = {x: bool(grid.looked_at[grid.cell_of(x, 0.0)]) for x in (-1.0, -0.3, 0.3, 0.6, 1.0)}
        assert looked_at == {-1.0: True, -0.3: True, 0.3: True, 0.6: False, 1.0: False}

    def test_it_looks_past_the_end_of_a_wall(self, grid: OccupancyGrid) -> None:
        self.wall(grid)
        grid.add_view(ORIGIN, math.tau)
        assert grid.looked_at[grid.cell_of(0.7, 1.2)]

    def test_it_looks_only_where_it_is_turned_to(self, grid: OccupancyGrid) -> None:
        grid.add_view(Pose(0.0, 0.0, math.pi / 2), math.radians(60))
        assert grid.looked_at[grid.cell_of(0.0, 1.0)]
        assert grid.looked_at[grid.cell_of(0.5, 1.0)]
        assert not grid.looked_at[grid.cell_of(0.8, 1.0)]
        assert not grid.looked_at[grid.cell_of(0.0, -1.0)]

    def test_rays_end_behind_what_is_taken(self, grid: OccupancyGrid) -> None:
        self.wall(grid)
        start = np.array([grid.cell_of(0.0, 0.0)])
        rows, columns, is_seen = grid.rays(start, np.array([0.0, math.pi]), step=1)
        seen_x = grid._centres[columns[0, 0][is_seen[0, 0]]]
        assert seen_x.max() < 0.5
        assert is_seen[0, 1].all()
        assert (rows[0, 0] == start[0, 0]).all()
