"""Draws the measurements of a calibration and their fits, below each other, as one PNG."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from robotcore.calibration.chart import Chart, Point
from robotcore.canvas import INK, PAPER, SERIES, Canvas, Colour, encode_png
from robotcore.view.page import save_png

WIDTH, HEIGHT = 800, 480
"""The size of a plot, in pixels."""

MARGIN = 0.05
"""The space around the values, as a share of their span."""

LEGEND_PX = 10
"""The height of the letters of the labels, in pixels."""


@dataclass(frozen=True)
class Series:
    """Points of a plot."""

    label: str
    points: Sequence[Point]
    is_line: bool = False
    """Whether a line joins the points. Otherwise each is a dot."""
    colour: Colour = SERIES[0]


@dataclass(frozen=True)
class Plot:
    """A chart of series, with its labels."""

    title: str
    x_label: str
    y_label: str
    series: Sequence[Series]

    def draw(self, canvas: Canvas, top: float) -> None:
        """Draw the plot on a canvas, from the row ``top`` on."""
        points = [point for series in self.series for point in series.points]
        ranges = _cover([x for x, _ in points]), _cover([y for _, y in points])
        chart = Chart(canvas, (0, top), (WIDTH, HEIGHT), *ranges)
        chart.draw_axes(self.title, self.x_label, self.y_label)
        left: float = WIDTH / 2
        for series in self.series:
            (chart.draw_curve if series.is_line else chart.draw_points)(series.points, series.colour)
            canvas.fill_circle((left, top + 29), 4, series.colour)
            left += canvas.write_text((left + 10, top + 33), series.label, INK, LEGEND_PX) + 34


def save_plots(plots: Sequence[Plot], path: Path) -> None:
    """Write plots below each other as a PNG. Raises UsageError if the file cannot be written."""
    canvas = Canvas(WIDTH, HEIGHT * len(plots), PAPER)
    for number, plot in enumerate(plots):
        plot.draw(canvas, number * HEIGHT)
    save_png(encode_png(canvas.render()), path, "--plot")


def _cover(values: Sequence[float]) -> Point:
    """Return the ends of an axis for all values."""
    finite = [value for value in values if math.isfinite(value)] or [0.0]
    low, high = min(finite), max(finite)
    space = MARGIN * ((high - low) or abs(high) or 1.0)
    return low - space, high + space
