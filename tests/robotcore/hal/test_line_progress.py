from __future__ import annotations

import pytest

from robotcore.description import Line
from robotcore.geometry import Pose
from robotcore.hal.line_progress import LineProgress

SQUARE = Line(width_m=0.02, points_m=((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)), closed=True)


def drive(line: Line, *points: tuple[float, float]) -> LineProgress:
    progress = LineProgress(line)
    for x, y in points:
        progress.update(Pose(x, y, 0.0))
    return progress


@pytest.mark.parametrize("is_reverse", [False, True])
def test_laps_of_a_closed_line_add_up(is_reverse: bool) -> None:
    lap = [(0.5, 0.0), (1.0, 0.5), (0.5, 1.02), (0.0, 0.5)]
    points = [*lap, *lap, lap[0]]
    progress = drive(SQUARE, *(points[::-1] if is_reverse else points))
    assert progress.length == pytest.approx(4.0)
    assert progress.followed_length == pytest.approx(8.0)
    assert progress.max_distance == pytest.approx(0.02)


def test_way_back_is_subtracted() -> None:
    assert drive(SQUARE, (0.1, 0.0), (0.9, 0.0), (0.3, 0.0)).followed_length == pytest.approx(0.2)


def test_robot_that_stands_follows_nothing() -> None:
    progress = drive(SQUARE, (0.5, -0.1), (0.5, -0.1))
    assert progress.followed_length == 0.0
    assert progress.max_distance == pytest.approx(0.1)
