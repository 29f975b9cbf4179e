from __future__ import annotations

import math

import numpy as np
import pytest

from robotcore.autonomy.navigation import OccupancyGrid, Target
from robotcore.autonomy.navigation.mapping import Map
from robotcore.autonomy.navigation.targets import RING_M, begins_known, is_unobstructed, straight_starts
from robotcore.geometry import Pose
from tests.robotcore.autonomy.navigation.places import HERE, take, veil

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
