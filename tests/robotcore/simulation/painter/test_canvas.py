from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.simulation.painter.canvas import fill

SHAPE = (40, 60)


def fill_canvas(polygon: list[tuple[float, float]]) -> np.ndarray:
    canvas = np.zeros(SHAPE, dtype=np.uint32)
    fill(canvas, polygon, 1)
    return canvas


def find_centres_inside(polygon: list[tuple[float, float]], margin: float = 0.0) -> np.ndarray:
    """Return a mask of the pixels whose centre is inside a polygon, at least ``margin`` pixels from its edges."""
    v, u = np.indices(SHAPE)
    inside = np.ones(SHAPE, dtype=bool)
    for (ax, ay), (bx, by) in zip(polygon, polygon[1:] + polygon[:1], strict=True):
        length = math.hypot(bx - ax, by - ay)
        inside &= (bx - ax) * (v - ay) - (by - ay) * (u - ax) >= margin * length
    return inside


def create_polygon(corners: int, x: float, y: float, radius: float, turn: float) -> list[tuple[float, float]]:
    angles = [turn + math.tau * i / corners for i in range(corners)]
    return [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles]


@given(st.integers(3, 9), st.floats(-10, 70), st.floats(-10, 50), st.floats(0.1, 200), st.floats(0, math.tau))
def test_pixels_are_filled_by_their_centres(corners: int, x: float, y: float, radius: float, turn: float) -> None:
    polygon = create_polygon(corners, x, y, radius, turn)
    canvas = fill_canvas(polygon).astype(bool)
    assert canvas[find_centres_inside(polygon, 1e-4)].all()
    assert not canvas[~find_centres_inside(polygon, -1e-4)].any()


def test_square_with_corners_at_pixel_centres_includes_these_pixels() -> None:
    canvas = fill_canvas([(2.0, 3.0), (5.0, 3.0), (5.0, 7.0), (2.0, 7.0)])
    assert (canvas[3:8, 2:6] == 1).all()
    assert canvas.sum() == 20


@pytest.mark.parametrize("slope", [0.0, 0.3, -0.7])
def test_neighbouring_polygons_leave_no_gap(slope: float) -> None:
    canvas = np.zeros(SHAPE, dtype=np.uint32)
    edges = [10 + 0.37 * i for i in range(60)]
    for left, right in pairwise(edges):
        fill(canvas, [(left, 5.0), (right, 5.0), (right + 30 * slope, 35.0), (left + 30 * slope, 35.0)], 1)
    assert all(len(np.unique(np.diff(np.flatnonzero(row)))) <= 1 for row in canvas)
    assert canvas[20].any()


def test_polygon_outside_the_canvas_changes_no_pixel() -> None:
    assert not fill_canvas([(-9.0, -9.0), (-5.0, -9.0), (-5.0, -5.0)]).any()
    assert fill_canvas([(-1e12, -1e12), (1e12, -1e12), (1e12, 1e12), (-1e12, 1e12)]).all()
