"""Charts: their axes, their lines and dots, and the sheet on which they stand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from robotcore.canvas import PAPER, Canvas
from robotcore.view.chart import Axis, Box, Chart, Series, draw_sheet

RED, BLUE = (250, 10, 10), (10, 10, 250)


@pytest.mark.parametrize(
    "low, high, ticks",
    [
        (0, 100, [0, 20, 40, 60, 80, 100]),
        (0, 37.2, [0, 10, 20, 30]),
        (0.3, 1.1, [0.4, 0.6, 0.8, 1.0]),
        (-3.1, 3.1, [-2, 0, 2]),
    ],
)
def test_an_axis_has_round_numbers(low: float, high: float, ticks: list[float]) -> None:
    assert Axis(low, high, 0, 1).list_ticks(count=5) == pytest.approx(ticks)


def draw(values: list[float], duration: float = 2.0, **style: Any) -> NDArray[np.bool_]:
    """Return which pixels are red in a chart of 400 x 200 pixels."""
    canvas, times = Canvas(400, 200, PAPER), np.linspace(0.0, 2.0, len(values))
    series = Series(times, np.array(values), RED, 3.0)._replace(**style)
    Chart("speed", [series], x_unit="s", x_range=(0.0, duration)).draw(canvas, Box(0, 0, 400, 200))
    return find(canvas.render(), RED)


def find(picture: NDArray[np.uint8], colour: tuple[int, int, int]) -> NDArray[np.bool_]:
    return np.asarray((picture[:, :, ::-1] == colour).all(axis=2))


def test_a_line_has_a_gap_at_values_that_are_not_finite() -> None:
    drawn = draw([1.0, 1.0, 1.0, np.nan, np.inf, 1.0, 1.0]).any(axis=0)
    columns = np.flatnonzero(drawn)
    assert (np.diff(columns) > 50).sum() == 1
    assert not draw([np.nan, np.inf]).any()


def test_dots_are_not_joined() -> None:
    columns = np.flatnonzero(draw([1.0, np.nan, 1.0, 2.0], has_dots=True).any(axis=0))
    assert (np.diff(columns) > 50).sum() == 2


def test_the_x_axis_ends_at_its_range() -> None:
    assert np.flatnonzero(draw([1.0, 2.0], 2.0).any(axis=0)).max() > 390
    assert np.flatnonzero(draw([1.0, 2.0], 4.0).any(axis=0)).max() == pytest.approx(44 + 178, abs=4)


def test_an_axis_maps_arrays_as_it_maps_numbers() -> None:
    axis = Axis(-1.0, 3.0, 100.0, 20.0)
    values = np.array([-1.0, 0.5, 3.0])
    assert axis.at_all(values).tolist() == [axis.at(value) for value in values]


def test_a_label_stands_in_the_legend_above_the_values() -> None:
    assert not draw([1.0, 1.0])[:40].any()
    assert draw([1.0, 1.0], label="red line")[:40].any()


def test_wide_numbers_stay_within_the_chart() -> None:
    picture = draw([1.0, 1.00001])
    assert np.flatnonzero(picture.any(axis=0)).min() > 60


def test_a_chart_without_series_is_its_title() -> None:
    canvas = Canvas(100, 50, PAPER)
    Chart("nothing", []).draw(canvas, Box(0, 0, 100, 50))
    assert (canvas.render() != PAPER[::-1]).any()


@pytest.mark.parametrize("count, columns, rows", [(1, 1, 1), (2, 2, 1), (3, 2, 2)])
def test_a_sheet_shows_two_charts_in_a_row(count: int, columns: int, rows: int) -> None:
    one = draw_sheet("one", [Chart("first", [Series([0.0, 1.0], [0.0, 1.0], BLUE)])])
    sheet = draw_sheet("all", [Chart("each", [Series([0.0, 1.0], [0.0, 1.0], BLUE)])] * count)
    assert find(sheet, BLUE).sum() == pytest.approx(count * find(one, BLUE).sum(), rel=0.01)
    assert sheet.shape[1] > columns * 600
    assert rows * 400 < sheet.shape[0] < rows * 600
