from __future__ import annotations

import numpy as np
import pytest

from robotcore.autonomy.navigation.mapping import Map
from robotcore.autonomy.navigation.paths import UNREACHED
from robotcore.autonomy.navigation.views import ELSEWHERE_M, KEPT_GAIN, MIN_GAIN_M2, View, _worths, best_view
from tests.robotcore.autonomy.navigation.places import REACH, take


def view_from_here(field: Map) -> View | None:
    return best_view(field.ground, field.coverage, field.grid.cell_of(0.0, 0.0))


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
