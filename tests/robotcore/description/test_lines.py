"""The lines on the floor of a world, in its file and on maps."""

from __future__ import annotations

import numpy as np
import pytest

from robotcore.description import Floor, Line, WorldDescription
from robotcore.description.doubtful_values import find_bodies_outside
from robotcore.view.overhead import draw_map
from tests.texts import CheckText

POINTS = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0))


def build_world(line: Line) -> WorldDescription:
    return WorldDescription(name="lined", floor=Floor(length_m=4, width_m=4), lines=(line,))


def test_closed_line_continues_to_its_first_point() -> None:
    line = Line(width_m=0.02, points_m=POINTS)
    assert line.segments == ((POINTS[0], POINTS[1]), (POINTS[1], POINTS[2]))
    assert line.model_copy(update={"closed": True}).segments[2:] == ((POINTS[2], POINTS[0]),)


def test_line_is_black_by_default_and_drawn_on_the_map() -> None:
    line = Line(width_m=0.2, points_m=((-1.0, 0.0), (1.0, 0.0)))
    plan = draw_map(build_world(line), [], 400)
    dark = np.argwhere((plan == 25).all(axis=2))
    (top, left), (bottom, right) = dark.min(axis=0), dark.max(axis=0)
    metre = (right - left) / 2.2
    assert metre == pytest.approx(400 / 4.24, rel=0.03)
    assert (bottom - top) / metre == pytest.approx(0.2, abs=0.03)


def test_line_beyond_the_floor_is_doubtful(check_text: CheckText) -> None:
    line = Line(width_m=0.02, points_m=((0.0, 0.0), (10.0, 0.0)))
    (warning,) = find_bodies_outside(build_world(line))
    check_text(warning)
