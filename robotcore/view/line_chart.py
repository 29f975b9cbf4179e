"""Draw charts of values over time: axes, grid lines and curves."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotcore.canvas import FADED, INK, RULE, Canvas, Colour, measure_text

Array = NDArray[np.float64]

_TEXT_PX = 11
_TITLE = 24
_LEFT, _BOTTOM = 44, 24
_TIME_ROOM, _VALUE_ROOM = 90, 34
"""The least distance between two grid lines along and across the time axis, in pixels."""


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


class Curve(NamedTuple):
    """A curve of a chart."""

    times: Array
    """The times in seconds, of shape (n,)."""
    values: Array
    """The values, of shape (n,). The curve has a gap at a value that is not finite."""
    colour: Colour
    width: float = 1.5
    """The width of the line in pixels."""


class Box(NamedTuple):
    """A rectangle on a canvas, in pixels."""

    left: float
    top: float
    width: float
    height: float


def draw_chart(canvas: Canvas, box: Box, title: str, curves: Sequence[Curve], duration: float) -> None:
    """Draw curves over time on a canvas, with a title, a grid and its numbers.

    box: the place of the chart with its title and its numbers. Without a finite value, only the title is drawn.
    duration: the end of the time axis, in seconds. It is greater than 0.
    """
    canvas.write_text((box.left, box.top + 14), title, INK, 13, bold=True)
    values = np.concatenate([*(curve.values[np.isfinite(curve.values)] for curve in curves), np.empty(0)])
    if not len(values):
        return
    low, high = float(values.min()), float(values.max())
    margin = 0.05 * (high - low) or 0.5
    bottom, right = box.top + box.height - _BOTTOM, box.left + box.width
    vertical = Axis(low - margin, high + margin, bottom, box.top + _TITLE)
    horizontal = Axis(0.0, duration, box.left + _LEFT, right)
    _draw_grid(canvas, horizontal, vertical)
    for curve in curves:
        for part in _split_gaps(curve):
            xs, ys = horizontal.at_all(curve.times[part]), vertical.at_all(curve.values[part])
            canvas.draw_line(list(zip(xs.tolist(), ys.tolist(), strict=True)), curve.colour, curve.width)


def _draw_grid(canvas: Canvas, horizontal: Axis, vertical: Axis) -> None:
    for value in vertical.list_ticks(max(2, int((vertical.start - vertical.end) / _VALUE_ROOM))):
        y, label = vertical.at(value), f"{value:g}"
        canvas.draw_line([(horizontal.start, y), (horizontal.end, y)], RULE, 1)
        canvas.write_text((horizontal.start - 8 - measure_text(label, _TEXT_PX), y + 4), label, FADED, _TEXT_PX)
    for value in horizontal.list_ticks(max(2, int((horizontal.end - horizontal.start) / _TIME_ROOM))):
        x, label = horizontal.at(value), f"{value:g} s"
        canvas.draw_line([(x, vertical.start), (x, vertical.end)], RULE, 1)
        canvas.write_text((x - measure_text(label, _TEXT_PX) / 2, vertical.start + 18), label, FADED, _TEXT_PX)


def _split_gaps(curve: Curve) -> list[slice]:
    """Return the parts of a curve between its gaps. A part has at least one value."""
    is_finite = np.isfinite(curve.values)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], is_finite, [False])).astype(int)))
    return [slice(int(start), int(end)) for start, end in edges.reshape(-1, 2)]
