from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.geometry import Pose
from robotcore.raycast import FAN_RAYS, FAN_SETBACK_M, Array, Fan, cast, edges_of

SQUARE = ((1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0))


def rays(*degrees: float) -> tuple[Array, Array]:
    angles = np.radians(np.array(degrees))
    return np.cos(angles), np.sin(angles)


class TestEdges:
    def test_an_outline_is_closed(self) -> None:
        assert edges_of([SQUARE[:3]]).tolist() == [[1, 1, -2, 0], [-1, 1, 0, -2], [-1, -1, 2, 2]]

    def test_no_outline_gives_no_edge(self) -> None:
        assert edges_of([]).shape == (0, 4)


class TestCast:
    def test_ray_hits_the_wall_in_every_direction(self) -> None:
        lengths = cast(0.0, 0.0, *rays(0, 90, 180, 270, 45), edges_of([SQUARE]))
        assert lengths == pytest.approx([1, 1, 1, 1, math.sqrt(2)])

    def test_ray_hits_the_nearest_edge(self) -> None:
        far = tuple((x + 5, y) for x, y in SQUARE)
        assert cast(3.0, 0.0, *rays(0, 180), edges_of([SQUARE, far])) == pytest.approx([1, 2])

    def test_distance_is_infinite_without_a_hit(self) -> None:
        assert cast(3.0, 0.0, *rays(0, 90), edges_of([SQUARE])).tolist() == [math.inf, math.inf]
        assert cast(0.0, 0.0, *rays(0, 90), edges_of([])).tolist() == [math.inf, math.inf]

    def test_a_ray_along_an_edge_meets_the_edge_beside_it(self) -> None:
        assert cast(3.0, 1.0, np.array([-1.0]), np.array([0.0]), edges_of([SQUARE])).tolist() == [2.0]

    @pytest.mark.parametrize("degrees, length", [(44, 1.390), (46, math.inf), (-44, 1.390), (-46, math.inf)])
    def test_ray_misses_beyond_the_ends_of_a_wall(self, degrees: float, length: float) -> None:
        wall = np.array([[1.0, -1.0, 0.0, 2.0]])
        assert cast(0.0, 0.0, *rays(degrees), wall) == pytest.approx([length], rel=1e-3)

    def test_lengths_are_in_units_of_the_direction(self) -> None:
        assert cast(0.0, 0.0, np.array([0.25]), np.array([0.0]), edges_of([SQUARE])) == pytest.approx([4.0])

    def test_each_ray_may_have_its_own_origin(self) -> None:
        x, y = np.array([0.0, 0.5]), np.array([0.0, 0.0])
        assert cast(x, y, *rays(0, 0), edges_of([SQUARE])) == pytest.approx([1.0, 0.5])

    @given(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9), st.floats(0, 360))
    def test_from_inside_every_ray_ends_on_the_outline(self, x: float, y: float, degrees: float) -> None:
        dx, dy = rays(degrees)
        (length,) = cast(x, y, dx, dy, edges_of([SQUARE]))
        assert max(abs(x + length * dx[0]), abs(y + length * dy[0])) == pytest.approx(1.0)


class TestFan:
    fan = Fan(cone=0.5, min_range=0.02, max_range=2.0)

    def test_rays_span_the_cone_from_right_to_left(self) -> None:
        assert len(self.fan.angles) == FAN_RAYS
        assert (self.fan.angles[0], self.fan.angles[FAN_RAYS // 2], self.fan.angles[-1]) == pytest.approx(
            (-0.25, 0, 0.25)
        )

    def test_rays_turn_with_the_sensor(self) -> None:
        dx, dy = self.fan.directions(Pose(3.0, 4.0, math.pi / 2))
        assert (dx[FAN_RAYS // 2], dy[FAN_RAYS // 2]) == pytest.approx((0.0, 1.0))
        assert dx[-1] < 0 < dx[0]

    @pytest.mark.parametrize(
        "distance, reading",
        [(0.5, 0.5), (2.0, 2.0), (2.001, math.inf), (math.inf, math.inf), (0.01, 0.02), (-0.04, 0.02)],
    )
    def test_reading_is_the_nearest_within_the_sensors_limits(self, distance: float, reading: float) -> None:
        lengths = np.array([9.0, distance + FAN_SETBACK_M, 9.0])
        assert self.fan.reading(lengths) == pytest.approx(reading)
