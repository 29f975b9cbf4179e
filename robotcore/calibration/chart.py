"""Draws charts of measurements on a canvas: axes, points and curves."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from robotcore.canvas import FADED, INK, RULE, Canvas, Colour, measure_text

_TEXT_PX, _TITLE_PX = 10, 13
_LEFT, _RIGHT, _TOP, _FOOT = 62, 16, 40, 46

Point = tuple[float, float]


class Chart:
    """A chart in a rectangle of a canvas.

    place: the left and the upper edge of the rectangle, in pixels.
    size: the width and the height of the rectangle, in pixels.
    x_range, y_range: the values at the ends of the axes.
    """

    def __init__(self, canvas: Canvas, place: Point, size: Point, x_range: Point, y_range: Point) -> None:
        self._canvas, self._place, self._size = canvas, place, size
        self._x_range, self._y_range = x_range, y_range

    def draw_axes(self, title: str, x_label: str, y_label: str) -> None:
        """Draw the title, the grid and the labels of the axes."""
        canvas, (left, top), (width, height) = self._canvas, self._place, self._size
        for value in list_ticks(*self._x_range):
            x, _ = self.locate(value, self._y_range[0])
            canvas.draw_line([(x, top + _TOP), (x, top + height - _FOOT)], RULE, 1)
            text = f"{value:g}"
            at = (x - measure_text(text, _TEXT_PX) / 2, top + height - _FOOT + 18)
            canvas.write_text(at, text, FADED, _TEXT_PX)
        for value in list_ticks(*self._y_range):
            _, y = self.locate(self._x_range[0], value)
            canvas.draw_line([(left + _LEFT, y), (left + width - _RIGHT, y)], RULE, 1)
            text = f"{value:g}"
            at = (left + _LEFT - 8 - measure_text(text, _TEXT_PX), y + _TEXT_PX / 2)
            canvas.write_text(at, text, FADED, _TEXT_PX)
        canvas.write_text((left + _LEFT, top + 16), title, INK, _TITLE_PX, bold=True)
        canvas.write_text((left + _LEFT, top + 33), y_label, FADED, _TEXT_PX)
        at = (left + width - _RIGHT - measure_text(x_label, _TEXT_PX), top + height - _FOOT + 36)
        canvas.write_text(at, x_label, FADED, _TEXT_PX)

    def draw_points(self, points: Iterable[Point], colour: Colour) -> None:
        """Draw a dot for each point of the chart's values."""
        for point in points:
            self._canvas.fill_circle(self.locate(*point), 3.5, colour)

    def draw_curve(self, points: Sequence[Point], colour: Colour, width: float = 1.5) -> None:
        """Draw a line through points of the chart's values."""
        self._canvas.draw_line([self.locate(*point) for point in points], colour, width)

    def locate(self, x: float, y: float) -> Point:
        """Return the place of a point of the chart's values on the canvas, in pixels."""
        (left, top), (width, height) = self._place, self._size
        across = (x - self._x_range[0]) / (self._x_range[1] - self._x_range[0])
        up = (y - self._y_range[0]) / (self._y_range[1] - self._y_range[0])
        return left + _LEFT + across * (width - _LEFT - _RIGHT), top + height - _FOOT - up * (height - _TOP - _FOOT)


def list_ticks(least: float, most: float, count: int = 5) -> list[float]:
    """Return about ``count`` round values between two ends.

    >>> list_ticks(-1.0, 1.0)
    [-1.0, -0.5, 0.0, 0.5, 1.0]
    """
    raw = (most - least) / max(count - 1, 1)
    scale = 10.0 ** math.floor(math.log10(raw))
    step = next(factor * scale for factor in (1, 2, 2.5, 5, 10) if factor * scale >= raw * (1 - 1e-9))
    first = math.ceil(least / step - 1e-9)
    return [number * step for number in range(first, math.floor(most / step + 1e-9) + 1)]
