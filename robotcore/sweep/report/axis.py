"""A scale from values to places along a drawing's edge, with round numbers on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from robotcore.sweep.report.svg import group, line, text

MAX_LABEL = 28
_LETTER, _GAP, _TICK_ROOM = 8.4, 12, 60


@dataclass(frozen=True)
class Axis:
    """Values from ``low`` to ``high`` lie between ``start`` and ``end``; ``low`` is less than ``high``."""

    low: float
    high: float
    start: float
    end: float

    def at(self, value: float) -> float:
        """Return where a value lies."""
        return self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)

    def ticks(self, about: int) -> list[float]:
        """Return about so many round values within the scale, at steps of 1, 2 or 5.

        P. S. Heckbert, Nice numbers for graph labels, Graphics Gems (1990).
        """
        rough = (self.high - self.low) / about
        unit = 10 ** math.floor(math.log10(rough))
        step = unit * next(size for size in (1, 2, 5, 10) if size * unit >= rough * (1 - 1e-9))
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return [index * step for index in range(first, last + 1)]


def room_for(labels: Iterable[str]) -> float:
    """Return how much room labels need beside a drawing, their gap to it among it."""
    longest = max((len(shortened(label)) for label in labels), default=0)
    return _GAP + _LETTER * longest


def shortened(label: str) -> str:
    """Return a label that is not too long to stand beside a drawing."""
    return label if len(label) <= MAX_LABEL else f"{label[: MAX_LABEL - 1]}…"


def label(axis: Axis, y: float, words: str) -> Element:
    """Return words that end at an axis's beginning, centred on a height."""
    return text((axis.start - _GAP, y + 4), shortened(words), text_anchor="end")


def below(axis: Axis, top: float, bottom: float, told: Callable[[float], str]) -> Element:
    """Return the grid of a horizontal axis from ``top`` to ``bottom``, its numbers below."""
    return group(_grid(axis, top, bottom, told), class_="axis")


def _grid(axis: Axis, top: float, bottom: float, told: Callable[[float], str]) -> Iterator[Element]:
    for value in axis.ticks(max(2, int((axis.end - axis.start) / _TICK_ROOM))):
        x = axis.at(value)
        yield line((x, top), (x, bottom))
        yield text((x, bottom + 16), told(value), text_anchor="middle")
