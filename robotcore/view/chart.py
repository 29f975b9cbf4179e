"""Draw charts on a canvas: axes, a grid, lines, dots and a legend."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.canvas import FADED, INK, PAPER, RULE, SERIES, Canvas, Colour, encode_png, measure_text, shorten_text
from robotcore.optics import Image
from robotcore.view.page import save_png

Array = NDArray[np.float64]

_HEADING_PX, _TITLE_PX, _TEXT_PX = 18, 13, 11
_TITLE_HEIGHT, _ROW_HEIGHT, _NUMBERS_HEIGHT = 24, 20, 24
"""The heights of the title, of the labels of the axes, and of the numbers below the x axis, in pixels."""

_LEFT, _GAP = 44, 8
"""The least width of the numbers beside the y axis, and the gap behind them, in pixels."""

_X_ROOM, _Y_ROOM = 90, 34
"""The least distance between two grid lines along and across the x axis, in pixels."""

_MARGIN = 0.05
"""The space around the values, as a share of their span."""

_DOT_PX = 3.5
"""The radius of a dot, in pixels."""

_WIDTH, _HEIGHT, _COLUMNS = 620, 440, 2
_EDGE, _HEADING_HEIGHT = 24, 60
"""The size of a chart on a sheet, the greatest number of charts in a row, the edge and the heading, in pixels."""


@dataclass(frozen=True)
class Axis:
    """A linear axis of a chart: maps values to coordinates of the drawing.

    >>> axis = Axis(low=0, high=100, start=50, end=450)
    >>> axis.at(25)
    150.0
    >>> axis.list_ticks(4)
    [0, 50, 100]
    """

    low: float
    """The value at the coordinate ``start``."""

    high: float
    """The value at the coordinate ``end``. It is greater than ``low``."""

    start: float
    """The coordinate of the value ``low``."""

    end: float
    """The coordinate of the value ``high``. It may be less than ``start``."""

    def at(self, value: float) -> float:
        """Return the coordinate of a value."""
        return self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)

    def at_all(self, values: Array) -> Array:
        """Return the coordinates of several values."""
        return self.start + (values - self.low) / (self.high - self.low) * (self.end - self.start)

    def list_ticks(self, count: int) -> list[float]:
        """Return about ``count`` round values of the axis, at steps of 1, 2 or 5 times a power of ten.

        Source: P. S. Heckbert, Nice numbers for graph labels, Graphics Gems (1990).
        """
        rough = (self.high - self.low) / count
        unit = 10 ** math.floor(math.log10(rough))
        step = unit * next(size for size in (1, 2, 5, 10) if size * unit >= rough * (1 - 1e-9))
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return [index * step for index in range(first, last + 1)]


class Series(NamedTuple):
    """Points of a chart."""

    xs: Sequence[float] | Array
    """The values on the x axis, of shape (n,)."""
    ys: Sequence[float] | Array
    """The values on the y axis, of shape (n,). A line has a gap at a value that is not finite."""
    colour: Colour = SERIES[0]
    width: float = 1.5
    """The width of the line in pixels."""
    label: str = ""
    """The words in the legend. Without any, the legend leaves out the series."""
    has_dots: bool = False
    """Whether each point is a dot. Otherwise a line joins the points."""


class Box(NamedTuple):
    """A rectangle on a canvas, in pixels."""

    left: float
    top: float
    width: float
    height: float


@dataclass(frozen=True)
class Chart:
    """A chart of series over a common x axis.

    >>> canvas = Canvas(400, 200, PAPER)
    >>> Chart("speed", [Series([0.0, 1.0, 2.0], [0.0, 0.2, 0.2])], x_unit="s").draw(canvas, Box(0, 0, 400, 200))
    """

    title: str
    series: Sequence[Series]
    x_label: str = ""
    y_label: str = ""
    x_unit: str = ""
    """The unit behind each number of the x axis."""
    x_range: tuple[float, float] | None = None
    """The ends of the x axis. By default, it shows all values."""
    y_range: tuple[float, float] | None = None
    """The ends of the y axis. By default, it shows all values."""

    def draw(self, canvas: Canvas, box: Box) -> None:
        """Draw the chart on a canvas. Without a finite value, only the title is drawn.

        box: the place of the chart with its title, its labels and its numbers.
        """
        canvas.write_text((box.left, box.top + 14), self.title, INK, _TITLE_PX, bold=True)
        xs, ys = _collect_finite(each.xs for each in self.series), _collect_finite(each.ys for each in self.series)
        if not (len(xs) and len(ys)):
            return
        has_row = bool(self.y_label or any(each.label for each in self.series))
        top = box.top + _TITLE_HEIGHT + has_row * _ROW_HEIGHT
        bottom = box.top + box.height - _NUMBERS_HEIGHT - bool(self.x_label) * _ROW_HEIGHT
        vertical = Axis(*(self.y_range or _cover(ys)), bottom, top)
        ticks = vertical.list_ticks(max(2, int((bottom - top) / _Y_ROOM)))
        left = max(_LEFT, _GAP + max((measure_text(f"{value:g}", _TEXT_PX) for value in ticks), default=0.0))
        horizontal = Axis(*(self.x_range or _cover(xs)), box.left + left, box.left + box.width)
        self._draw_grid(canvas, horizontal, vertical, ticks)
        self._draw_labels(canvas, box, box.left + left)
        for each in self.series:
            _draw_series(canvas, each, horizontal, vertical)

    def _draw_grid(self, canvas: Canvas, horizontal: Axis, vertical: Axis, ticks: Sequence[float]) -> None:
        for value in ticks:
            y, label = vertical.at(value), f"{value:g}"
            canvas.draw_line([(horizontal.start, y), (horizontal.end, y)], RULE, 1)
            canvas.write_text((horizontal.start - _GAP - measure_text(label, _TEXT_PX), y + 4), label, FADED, _TEXT_PX)
        for value in horizontal.list_ticks(max(2, int((horizontal.end - horizontal.start) / _X_ROOM))):
            x, label = horizontal.at(value), f"{value:g} {self.x_unit}".rstrip()
            canvas.draw_line([(x, vertical.start), (x, vertical.end)], RULE, 1)
            canvas.write_text((x - measure_text(label, _TEXT_PX) / 2, vertical.start + 18), label, FADED, _TEXT_PX)

    def _draw_labels(self, canvas: Canvas, box: Box, left: float) -> None:
        """Draw the labels of both axes, and the legend in the row of the y label."""
        row = box.top + _TITLE_HEIGHT + 10
        if self.x_label:
            x = box.left + box.width - measure_text(self.x_label, _TEXT_PX)
            canvas.write_text((x, box.top + box.height - 5), self.x_label, FADED, _TEXT_PX)
        left += canvas.write_text((left, row), self.y_label, FADED, _TEXT_PX) + 34
        for each in self.series:
            if each.label:
                if each.has_dots:
                    canvas.fill_circle((left, row - 4), _DOT_PX, each.colour)
                else:
                    canvas.draw_line([(left - 8, row - 4), (left + 6, row - 4)], each.colour, each.width)
                left += canvas.write_text((left + 12, row), each.label, INK, _TEXT_PX) + 38


def save_charts(file: Path, heading: str, charts: Sequence[Chart], option: str) -> None:
    """Write a heading and charts as a PNG. Raises UsageError if the file cannot be written.

    option: the option of the command line that names the file.
    """
    save_png(encode_png(draw_sheet(heading, charts)), file, option)


def draw_sheet(heading: str, charts: Sequence[Chart]) -> Image:
    """Return a picture with a heading and with charts below it, two in a row."""
    columns = min(len(charts), _COLUMNS)
    rows = (len(charts) + _COLUMNS - 1) // _COLUMNS
    size = columns * (_WIDTH + _EDGE) + _EDGE, _HEADING_HEIGHT + rows * (_HEIGHT + _EDGE)
    canvas = Canvas(*size, PAPER)
    heading = shorten_text(heading, size[0] - 2 * _EDGE, _HEADING_PX, bold=True)
    canvas.write_text((_EDGE, 36), heading, INK, _HEADING_PX, bold=True)
    for number, chart in enumerate(charts):
        left = _EDGE + number % _COLUMNS * (_WIDTH + _EDGE)
        top = _HEADING_HEIGHT + number // _COLUMNS * (_HEIGHT + _EDGE)
        chart.draw(canvas, Box(left, top, _WIDTH, _HEIGHT))
    return canvas.render()


def _draw_series(canvas: Canvas, series: Series, horizontal: Axis, vertical: Axis) -> None:
    xs, ys = (np.asarray(values, float) for values in (series.xs, series.ys))
    for part in _split_gaps(ys):
        places = list(zip(horizontal.at_all(xs[part]).tolist(), vertical.at_all(ys[part]).tolist(), strict=True))
        if series.has_dots:
            for place in places:
                canvas.fill_circle(place, _DOT_PX, series.colour)
        else:
            canvas.draw_line(places, series.colour, series.width)


def _split_gaps(values: Array) -> list[slice]:
    """Return the parts of a line between its gaps. A part has at least one value."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], np.isfinite(values), [False])).astype(int)))
    return [slice(int(start), int(end)) for start, end in edges.reshape(-1, 2)]


def _collect_finite(columns: Iterable[Sequence[float] | Array]) -> Array:
    values: Array = np.concatenate([*(np.asarray(each, np.float64) for each in columns), np.empty(0)])
    return np.asarray(values[np.isfinite(values)])


def _cover(values: Array) -> tuple[float, float]:
    """Return the ends of an axis that shows all values."""
    low, high = float(values.min()), float(values.max())
    margin = _MARGIN * (high - low) or 0.5
    return low - margin, high + margin
