"""Parts of charts: SVG elements, axes and labels."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from xml.etree.ElementTree import Element, tostring

from robotcore.view.chart import Axis

Attribute = str | float
Point = tuple[float, float]

MAX_LABEL = 28
"""The maximum length of a label, in characters."""

_LETTER, _GAP, _TICK_ROOM = 8.4, 12, 60


def element(tag: str, *children: Element | str, **attributes: Attribute) -> Element:
    """Return an SVG element.

    tag: the name of the element.
    children: its child elements, or its text.
    attributes: its attributes. In a name, a trailing underscore is dropped, and any other becomes a hyphen.

    >>> tostring(element("line", x1=0.25, class_="axis", stroke_width=2.0))
    b'<line x1="0.2" class="axis" stroke-width="2" />'
    """
    names = {name.rstrip("_").replace("_", "-"): _format_value(value) for name, value in attributes.items()}
    made = Element(tag, names)
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
    drawing = element("svg", *children, role="img", aria_label=description, **box, **attributes)
    return tostring(drawing, encoding="unicode")


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
    way = "L".join(f"{_format_value(x)} {_format_value(y)}" for x, y in points)
    return element("path", d=f"M{way}", **attributes)


def _format_value(value: Attribute) -> str:
    return value if isinstance(value, str) else f"{value:.1f}".removesuffix(".0")


class SvgAxis(Axis):
    """A linear axis of a chart in SVG."""

    def draw_grid(self, top: float, bottom: float, format_tick: Callable[[float], str]) -> Element:
        """Return the grid of a horizontal axis: vertical lines from ``top`` to ``bottom`` with a number below each."""
        ticks = [
            (self.at(value), value) for value in self.list_ticks(max(2, int((self.end - self.start) / _TICK_ROOM)))
        ]
        lines = [line((x, top), (x, bottom)) for x, _ in ticks]
        numbers = [text((x, bottom + 16), format_tick(value), text_anchor="middle") for x, value in ticks]
        return group([*lines, *numbers], class_="axis")

    def draw_label(self, y: float, words: str) -> Element:
        """Return an SVG element for a label left of the axis, centred vertically at ``y``."""
        return text((self.start - _GAP, y + 4), shorten_label(words), text_anchor="end")


def measure_labels(labels: Iterable[str]) -> float:
    """Return the width of the longest label, plus the gap between label and chart."""
    return _GAP + _LETTER * max((len(shorten_label(label)) for label in labels), default=0)


def shorten_label(label: str) -> str:
    """Return a label shortened to at most `MAX_LABEL` characters."""
    return label if len(label) <= MAX_LABEL else f"{label[: MAX_LABEL - 1]}…"
