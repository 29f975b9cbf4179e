"""Draws the measurements of a calibration and the fit, as a PNG."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robotcore.canvas import FADED, INK, PAPER, RULE, SERIES, Canvas, Colour, Point, encode_png
from robotcore.errors import UsageError
from robotcore.optics import Image

WIDTH, HEIGHT = 800, 500
LEFT, RIGHT, TOP, BOTTOM = 84, 24, 58, 58
"""The margins around the area of the values, in pixels."""

TEXT, TITLE = 10.0, 14.0
"""The heights of letters, in pixels."""

TICKS = 6
"""About this many values are written along an axis."""


@dataclass(frozen=True)
class Series:
    """Points of a chart."""

    label: str
    points: Sequence[Point]
    is_line: bool = False
    """Whether a line joins the points. Otherwise each is a dot."""
    colour: Colour = SERIES[0]


@dataclass(frozen=True)
class Chart:
    """A chart of points and lines.

    >>> chart = Chart("Errors", "distance in m", "error in m", (Series("echoes", [(0.2, 0.01), (1.0, 0.02)]),))
    >>> chart.draw().shape
    (500, 800, 3)
    """

    title: str
    x_label: str
    y_label: str
    series: Sequence[Series]

    def draw(self) -> Image:
        """Return the chart as a BGR picture."""
        canvas = Canvas(WIDTH, HEIGHT, PAPER)
        points = [point for series in self.series for point in series.points]
        x_axis = _Axis.cover([x for x, _ in points], LEFT, WIDTH - RIGHT)
        y_axis = _Axis.cover([y for _, y in points], HEIGHT - BOTTOM, TOP)
        canvas.write_text((LEFT, 26), self.title, INK, TITLE, bold=True)
        for value in x_axis.ticks:
            x = x_axis.place(value)
            canvas.draw_line([(x, TOP), (x, HEIGHT - BOTTOM)], RULE, 1)
            canvas.write_text((x - 12, HEIGHT - BOTTOM + 20), f"{value:g}", FADED, TEXT)
        for value in y_axis.ticks:
            y = y_axis.place(value)
            canvas.draw_line([(LEFT, y), (WIDTH - RIGHT, y)], RULE, 1)
            canvas.write_text((8, y + TEXT / 2), f"{value:g}", FADED, TEXT)
        canvas.write_text((LEFT, HEIGHT - 14), self.x_label, INK, TEXT)
        canvas.write_text((8, TOP - 14), self.y_label, INK, TEXT)
        right: float = WIDTH / 2
        for series in self.series:
            places = [(x_axis.place(x), y_axis.place(y)) for x, y in series.points]
            if series.is_line and len(places) > 1:
                canvas.draw_line(places, series.colour, 2)
            elif not series.is_line:
                for place in places:
                    canvas.fill_circle(place, 3.5, series.colour)
            canvas.fill_circle((right, TOP - 18), 4, series.colour)
            right += canvas.write_text((right + 10, TOP - 14), series.label, INK, TEXT) + 34
        return canvas.render()


def save_charts(charts: Sequence[Chart], path: Path) -> None:
    """Write charts below each other as a PNG. Raises UsageError if the file cannot be written."""
    try:
        path.write_bytes(encode_png(np.vstack([chart.draw() for chart in charts])))
    except OSError as error:
        text = f"the plot {path} cannot be written: {error.strerror}. Name another file with --plot"
        raise UsageError(text, kind="unwritable-plot", file=str(path)) from error


@dataclass(frozen=True)
class _Axis:
    low: float
    high: float
    begin: float
    end: float
    ticks: Sequence[float]

    @classmethod
    def cover(cls, values: Sequence[float], begin: float, end: float) -> _Axis:
        """Return an axis for all values, from the pixel ``begin`` to the pixel ``end``."""
        finite = [value for value in values if math.isfinite(value)] or [0.0]
        low, high = min(finite), max(finite)
        span = high - low or abs(high) or 1.0
        low, high = low - 0.05 * span, high + 0.05 * span
        step = _round_step((high - low) / TICKS)
        first = math.ceil(low / step)
        ticks = [round(number * step, 12) for number in range(first, math.floor(high / step) + 1)]
        return cls(low, high, begin, end, ticks)

    def place(self, value: float) -> float:
        return self.begin + (value - self.low) / (self.high - self.low) * (self.end - self.begin)


def _round_step(step: float) -> float:
    """Return 1, 2 or 5 times a power of ten that is at least ``step``."""
    power = 10.0 ** math.floor(math.log10(step))
    return next(factor * power for factor in (1, 2, 5, 10) if factor * power >= step * (1 - 1e-9))
