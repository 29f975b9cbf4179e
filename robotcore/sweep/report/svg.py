"""Drawings as SVG text: colours come from the page's style sheet, so that a drawing is dark where the page is."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element, tostring

Attribute = str | float
Point = tuple[float, float]


def element(tag: str, *children: Element | str, **attributes: Attribute) -> Element:
    """Return an element; a trailing underscore of an attribute's name is dropped, others become hyphens."""
    made = Element(tag, {name.rstrip("_").replace("_", "-"): _told(value) for name, value in attributes.items()})
    for child in children:
        if isinstance(child, str):
            made.text = child
        else:
            made.append(child)
    return made


def drawing(width: float, height: float, told: str, children: Iterable[Element], **attributes: Attribute) -> str:
    """Return a whole drawing, its origin top left, as text that is safe in HTML; ``told`` is read to who cannot see."""
    box = {"viewBox": f"0 0 {_told(width)} {_told(height)}"}
    return tostring(element("svg", *children, role="img", aria_label=told, **box, **attributes), encoding="unicode")


def group(children: Iterable[Element], **attributes: Attribute) -> Element:
    """Return elements that have attributes in common."""
    return element("g", *children, **attributes)


def line(start: Point, end: Point, **attributes: Attribute) -> Element:
    """Return a straight line."""
    return element("line", x1=start[0], y1=start[1], x2=end[0], y2=end[1], **attributes)


def text(place: Point, words: str, **attributes: Attribute) -> Element:
    """Return words whose baseline begins at a place."""
    return element("text", words, x=place[0], y=place[1], **attributes)


def dot(centre: Point, radius: float, **attributes: Attribute) -> Element:
    """Return a filled circle."""
    return element("circle", cx=centre[0], cy=centre[1], r=radius, **attributes)


def trail(points: Iterable[Point], **attributes: Attribute) -> Element:
    """Return an open line through points."""
    (x, y), *rest = points
    way = f"M{_told(x)} {_told(y)}" + "".join(f"L{_told(x)} {_told(y)}" for x, y in rest)
    return element("path", d=way, **attributes)


def _told(value: Attribute) -> str:
    return value if isinstance(value, str) else f"{value:.1f}".removesuffix(".0")
