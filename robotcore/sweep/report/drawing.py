"""Parts of charts: SVG elements, axes, labels and colours."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple
from xml.etree.ElementTree import Element, tostring

from robotcore.view.canvas import SERIES, Colour, lighten

Attribute = str | float
Point = tuple[float, float]

MAX_LABEL = 28
"""The maximum length of a label, in characters."""

_LETTER, _GAP, _TICK_ROOM = 8.4, 12, 60

_WHITE_SHARE = 0.42
"""The share of white, from 0 to 1, that is mixed into a colour for a dark page."""


def element(tag: str, *children: Element | str, **attributes: Attribute) -> Element:
    """Return an SVG element.

    tag: the name of the element.
    children: its child elements, or its text.
    attributes: its attributes. In a name, a trailing underscore is dropped, and any other becomes a hyphen.

    >>> tostring(element("line", x1=0.25, class_="axis", stroke_width=2.0))
    b'<line x1="0.2" class="axis" stroke-width="2" />'
    """
    made = Element(
        tag, {name.rstrip("_").replace("_", "-"): _format_value(value) for name, value in attributes.items()}
    )
    for child in children:
        if isinstance(child, str):
            made.text = child
        else:
            made.append(child)
    return made


def render_svg(
    width: float, height: float, description: str, children: Iterable[Element], **attributes: Attribute
) -> str:
    """Return an SVG drawing as text that is safe in HTML.

    description: the text that a screen reader reads in place of the drawing.
    """
    box = {"viewBox": f"0 0 {_format_value(width)} {_format_value(height)}"}
    return tostring(
        element("svg", *children, role="img", aria_label=description, **box, **attributes), encoding="unicode"
    )


def group(children: Iterable[Element], **attributes: Attribute) -> Element:
    """Return an SVG group of elements with common attributes."""
    return element("g", *children, **attributes)


def line(start: Point, end: Point, **attributes: Attribute) -> Element:
    """Return an SVG element for a straight line."""
    return element("line", x1=start[0], y1=start[1], x2=end[0], y2=end[1], **attributes)


def text(start: Point, words: str, **attributes: Attribute) -> Element:
    """Return an SVG element for a text whose baseline begins at ``start``."""
    return element("text", words, x=start[0], y=start[1], **attributes)


def dot(centre: Point, radius: float, **attributes: Attribute) -> Element:
    """Return an SVG element for a filled circle."""
    return element("circle", cx=centre[0], cy=centre[1], r=radius, **attributes)


def polyline(points: Iterable[Point], **attributes: Attribute) -> Element:
    """Return an SVG element for an open line through points."""
    (x, y), *rest = points
    way = f"M{_format_value(x)} {_format_value(y)}" + "".join(
        f"L{_format_value(x)} {_format_value(y)}" for x, y in rest
    )
    return element("path", d=way, **attributes)


def _format_value(value: Attribute) -> str:
    return value if isinstance(value, str) else f"{value:.1f}".removesuffix(".0")


@dataclass(frozen=True)
class Axis:
    """A linear axis of a chart: maps values to coordinates in SVG.

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

    def list_ticks(self, count: int) -> list[float]:
        """Return about ``count`` round values of the axis, at steps of 1, 2 or 5 times a power of ten.

        Source: P. S. Heckbert, Nice numbers for graph labels, Graphics Gems (1990).
        """
        rough = (self.high - self.low) / count
        unit = 10 ** math.floor(math.log10(rough))
        step = unit * next(size for size in (1, 2, 5, 10) if size * unit >= rough * (1 - 1e-9))
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return [index * step for index in range(first, last + 1)]


def measure_labels(labels: Iterable[str]) -> float:
    """Return the width of the longest label, plus the gap between label and chart."""
    longest = max((len(shorten_label(label)) for label in labels), default=0)
    return _GAP + _LETTER * longest


def shorten_label(label: str) -> str:
    """Return a label shortened to at most `MAX_LABEL` characters."""
    return label if len(label) <= MAX_LABEL else f"{label[: MAX_LABEL - 1]}…"


def draw_label(axis: Axis, y: float, words: str) -> Element:
    """Return an SVG element for a label left of an axis, centred vertically at ``y``."""
    return text((axis.start - _GAP, y + 4), shorten_label(words), text_anchor="end")


def draw_axis(axis: Axis, top: float, bottom: float, format_tick: Callable[[float], str]) -> Element:
    """Return the grid of a horizontal axis: vertical lines from ``top`` to ``bottom`` with a number below each."""
    return group(_draw_grid(axis, top, bottom, format_tick), class_="axis")


def _draw_grid(axis: Axis, top: float, bottom: float, format_tick: Callable[[float], str]) -> Iterator[Element]:
    for value in axis.list_ticks(max(2, int((axis.end - axis.start) / _TICK_ROOM))):
        x = axis.at(value)
        yield line((x, top), (x, bottom))
        yield text((x, bottom + 16), format_tick(value), text_anchor="middle")


class Shades(NamedTuple):
    """A colour in CSS, such as ``#2463eb``, for a light page and for a dark page."""

    light: str
    """The colour on a light page."""

    dark: str
    """The colour on a dark page."""


def compute_shades(names: Sequence[str]) -> list[Shades]:
    """Return a colour for each name. People with the common kinds of colour blindness can distinguish the colours."""
    colours = (SERIES[index % len(SERIES)] for index in range(len(names)))
    return [Shades(_css(colour), _css(lighten(colour, _WHITE_SHARE))) for colour in colours]


def _css(colour: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)
