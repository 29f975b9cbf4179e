from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotcore.autonomy.navigation.grid_paths import (
    UNREACHED,
    Cell,
    Mask,
    are_straight_ways,
    backtrack,
    compute_rays,
    cut_out,
    is_straight_way,
    mask_hidden,
    set_outside,
    wavefront,
)

NEAR = f"{wavefront.__module__}.NEAR_CELLS"
EDGES = [(-1, 0), (1, 0), (0, -1), (0, 1)]
CORNERS = [(-1, -1), (-1, 1), (1, -1), (1, 1)]


def neighbours(cell: Cell, offsets: list[Cell], open_cells: Mask) -> Iterator[Cell]:
    for dr, dc in offsets:
        r, c = cell[0] + dr, cell[1] + dc
        if 0 <= r < open_cells.shape[0] and 0 <= c < open_cells.shape[1] and open_cells[r, c]:
            yield r, c


def compute_steps(start: Cell, open_cells: Mask) -> dict[Cell, int]:
    """Return the step that reaches each cell. Odd steps go over edges and corners, even steps over edges."""
    reached = {start: 0}
    for step in range(1, 2 * open_cells.size):
        offsets = EDGES + CORNERS if step % 2 else EDGES
        new = {near for cell in reached for near in neighbours(cell, offsets, open_cells)} - reached.keys()
        reached.update(dict.fromkeys(new, step))
    return reached


def masks() -> st.SearchStrategy[Mask]:
    rows = st.lists(st.lists(st.booleans(), min_size=6, max_size=6), min_size=5, max_size=5)
    return rows.map(np.array)


@settings(max_examples=40)
@given(masks(), st.integers(0, 4), st.integers(0, 5))
def test_steps_equal_those_of_a_simple_wave(open_cells: Mask, row: int, column: int) -> None:
    steps = wavefront((row, column), open_cells)
    is_line_free = compute_steps((row, column), open_cells)
    for cell in np.ndindex(*open_cells.shape):
        assert steps[cell] == is_line_free.get((cell[0], cell[1]), UNREACHED)


@given(masks(), st.integers(0, 4), st.integers(0, 5))
def test_backtracked_path_leads_over_open_neighbours(open_cells: Mask, row: int, column: int) -> None:
    start = (row, column)
    steps = wavefront(start, open_cells)
    for goal in map(tuple, np.argwhere(steps != UNREACHED)):
        path = backtrack(steps, goal)
        assert (path[0], path[-1]) == (start, goal)
        assert len(path) <= steps[goal] + 1
        assert all(open_cells[cell] for cell in path[1:])
        for (r, c), (following_r, following_c) in pairwise(path):
            assert max(abs(following_r - r), abs(following_c - c)) == 1


@given(masks(), masks(), st.integers(0, 4), st.integers(0, 5))
def test_path_to_the_nearest_goal_is_the_same_if_near_cells_are_searched_first(
    open_cells: Mask, goals: Mask, row: int, column: int
) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(NEAR, 2)
        near = wavefront((row, column), open_cells, goals)
        patch.setattr(NEAR, 0)
        assert np.array_equal(near, wavefront((row, column), open_cells, goals))


@pytest.mark.parametrize("length", [1, 2, 50])
def test_wave_ends_in_a_long_narrow_passage(length: int) -> None:
    steps = wavefront((0, 0), np.ones((1, length), np.bool_))
    assert steps[0].tolist() == list(range(length))


def test_a_wave_ends_at_the_nearest_goal() -> None:
    goals = np.array([[False, False, True, False, True]])
    steps = wavefront((0, 0), np.ones((1, 5), np.bool_), goals)
    assert steps[0].tolist() == [0, 1, 2, UNREACHED, UNREACHED]


def is_line_free(open_cells: Mask, start: Cell, goal: Cell) -> bool:
    """Return whether all cells of a line except for its start are open, with two points for each cell."""
    count = 2 * max(abs(goal[0] - start[0]), abs(goal[1] - start[1])) + 1
    points = np.linspace(start, goal, count).round().astype(int)
    return all(open_cells[row, column] or (row, column) == start for row, column in points)


@settings(max_examples=40)
@given(masks(), st.lists(st.tuples(st.integers(0, 4), st.integers(0, 5)), min_size=1), st.integers(0, 4))
def test_many_lines_at_once_give_the_results_of_single_lines(open_cells: Mask, starts: list[Cell], row: int) -> None:
    goal = (row, 3)
    expected = [is_line_free(open_cells, start, goal) for start in starts]
    assert are_straight_ways(open_cells, starts, [goal]).tolist() == expected
    assert [is_straight_way(open_cells, start, goal) for start in starts] == expected


def test_cells_outside_the_grid_are_open() -> None:
    open_cells = np.array([[False, True, True, False]])
    goals = [(-7, 9), (0, 9)]
    assert [is_straight_way(open_cells, (0, 2), goal) for goal in goals] == [True, False]
    assert are_straight_ways(open_cells, [(0, 2)], goals).tolist() == [True, False]


def test_rays_go_along_columns_and_rows() -> None:
    rays = compute_rays(np.array([0.0, math.pi / 2, math.pi]), np.array([1, 2, 3]))
    assert rays.rows.tolist() == [[0, 0, 0], [1, 2, 3], [0, 0, 0]]
    assert rays.columns.tolist() == [[1, 2, 3], [0, 0, 0], [-1, -2, -3]]
    assert rays.index(10).tolist() == [[1, 2, 3], [10, 20, 30], [-1, -2, -3]]
    assert rays.index(7).tolist() == [[1, 2, 3], [7, 14, 21], [-1, -2, -3]]
    assert rays.lie_within(0, -1, 3).tolist() == [[True, False, False], [True, True, False], [True, False, False]]


@pytest.mark.parametrize(
    "low, high, expected",
    [
        ((0, 1), (1, 2), [[2, 3], [5, 6]]),
        ((-1, 2), (0, 4), [[9, 9, 9], [3, 9, 9]]),
        ((1, -1), (3, 0), [[9, 4], [9, 9], [9, 9]]),
        ((5, 5), (6, 5), [[9], [9]]),
        ((-9, -9), (-8, -8), [[9, 9], [9, 9]]),
    ],
    ids=["inside", "top right corner", "bottom left corner", "beyond the end", "before the start"],
)
def test_rectangle_has_a_given_value_outside_the_grid(low: Cell, high: Cell, expected: list[list[int]]) -> None:
    grid = np.array([[1, 2, 3], [4, 5, 6]])
    rectangle = cut_out(grid, low, high)
    set_outside(rectangle, low, grid.shape, 9)
    assert rectangle.tolist() == expected
    assert grid.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_cell_hides_itself_and_all_cells_behind() -> None:
    hides = np.array([[[False, True, False], [False, False, False]]])
    assert mask_hidden(hides).tolist() == [[[False, True, True], [False, False, False]]]
