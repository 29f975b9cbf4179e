from __future__ import annotations

from robotcore.autonomy.navigation.grid import OccupancyGrid
from robotcore.autonomy.navigation.ground import MARGINS_M, NO_WAY, Trust
from robotcore.autonomy.navigation.mapping import Map
from robotcore.autonomy.navigation.paths import Cell
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
    is_open = {trust: [bool(field.ground.open_cells(here, trust)[0][place]) for place in places] for trust in Trust}
    assert is_open == {
        Trust.KNOWN: [False, False, False],
        Trust.UNKNOWN: [True, False, False],
        Trust.DOUBTFUL: [True, True, False],
    }


def test_what_is_barred_is_closed_unless_it_is_known(field: Map) -> None:
    here, there = cell(field.grid, 0.0), cell(field.grid, 1.0)
    field.ground.bar(there)
    is_open = [bool(field.ground.open_cells(here, trust)[0][there]) for trust in Trust]
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
    assert field.ground.way_to(field.grid.cell_of(HERE.x, HERE.y), cell(field.grid, 1.0)) is NO_WAY
