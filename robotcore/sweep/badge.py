"""The badge of a sweep: a small SVG picture with the success rate, its interval, and the colour of the gate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple
from xml.etree import ElementTree as ET

from robotcore.runtime.apps import app_path
from robotcore.sweep.statistics import Group, Requirement, wilson
from robotcore.text import escape, pluralize

MAX_NAME = 40
"""The maximum number of characters of the app's name on a badge."""

HEIGHT_PX, SIZE_PX, MARGIN_PX = 20, 11, 7
"""The height of a badge, of its letters, and the margin beside a text, in pixels."""

_WIDE, _NARROW = frozenset("mwMW%@©—"), frozenset("fijlrtI.,:;'()[]!| ")
_WIDTHS_PX = {"wide": 10.2, "narrow": 4.1, "usual": 6.7}
"""The widths of letters of Verdana in this size. ``textLength`` fits another font into the same width."""

_DARK, _GREY = "#3c4149", "#5f6670"
_GREEN, _RED, _BLUE = "#227a3f", "#b3261e", "#2a5fa8"
"""The colours behind white text, with a contrast of at least 4.5 : 1 (WCAG 2.1, level AA)."""


class BadgeText(NamedTuple):
    """The texts of a badge, and its colour."""

    label: str
    message: str
    colour: str


def build_error_text(app: str) -> BadgeText:
    """Return the text of the badge of a sweep that has no results, because it failed.

    >>> build_error_text("green-search").message
    'error'
    """
    return BadgeText(_shorten(app), "error", _GREY)


def build_badge_text(app: str, groups: Sequence[Group], requirements: Sequence[Requirement]) -> BadgeText:
    """Return what a badge says about a sweep.

    app: the name or the file of the app.
    groups: the counts of each backend in each world. With several, the badge has the lowest rate.
    requirements: the requirements. The badge is green if all groups meet them, red if one does not, and blue if there
        are none.
    """
    group = min(groups, key=_get_rate)
    count, verb = (group.successes, "succeeded") if group.verified is None else (group.verified, "verified")
    low, high = map(_format_percent, wilson(count, group.runs))
    rate = f"{_format_percent(count / group.runs)} % of {pluralize(group.runs, 'run')} {verb} ({low}–{high} %)"
    message = rate if len(groups) == 1 else f"{rate}, lowest of {len(groups)} groups"
    label = _shorten(app)
    if not requirements:
        return BadgeText(label, message, _BLUE)
    is_met = all(each.is_met_by(group) for each in requirements for group in groups)
    return BadgeText(label, f"{'passed' if is_met else 'failed'}: {message}", _GREEN if is_met else _RED)


def draw_badge(text: BadgeText) -> bytes:
    """Return a badge as an SVG file, which refers to no other file.

    >>> draw_badge(BadgeText("search", "100 % verified", "#2a5fa8")).decode().startswith("<svg xmlns=")
    True
    """
    label, message = escape(text.label), escape(text.message)
    left, right = (_measure(part) + 2 * MARGIN_PX for part in (label, message))
    root = ET.Element(
        "svg",
        {"xmlns": "http://www.w3.org/2000/svg", "role": "img", "aria-label": f"{label}: {message}"},
        width=f"{left + right:.1f}",
        height=str(HEIGHT_PX),
    )
    ET.SubElement(root, "title").text = f"{label}: {message}. In brackets: the 95 % interval"
    clip = ET.SubElement(root, "clipPath", id="corners")
    ET.SubElement(clip, "rect", width=f"{left + right:.1f}", height=str(HEIGHT_PX), rx="3")
    boxes = ET.SubElement(root, "g", {"clip-path": "url(#corners)"})
    letters = ET.SubElement(
        root, "g", {"fill": "#fff", "font-family": "Verdana,DejaVu Sans,sans-serif", "font-size": str(SIZE_PX)}
    )
    for begin, width, colour, part in ((0.0, left, _DARK, label), (left, right, text.colour, message)):
        ET.SubElement(boxes, "rect", x=f"{begin:.1f}", width=f"{width:.1f}", height=str(HEIGHT_PX), fill=colour)
        shape = ET.SubElement(letters, "text", x=f"{begin + MARGIN_PX:.1f}", y="14")
        shape.set("textLength", f"{width - 2 * MARGIN_PX:.1f}")
        shape.text = part
    content: bytes = ET.tostring(root, encoding="utf-8")
    return content + b"\n"


def _shorten(app: str) -> str:
    name = app_path(app).stem
    return name if len(name) <= MAX_NAME else f"{name[: MAX_NAME - 1]}…"


def _get_rate(group: Group) -> float:
    return group.success_share if group.verified_share is None else group.verified_share


def _format_percent(share: float) -> str:
    """Return a share in percent without decimals. Only the share 1 is 100 %, and only the share 0 is 0 %."""
    percent = round(100 * share)
    return str(min(max(percent, 1), 99) if 0 < share < 1 else percent)


def _measure(text: str) -> float:
    kinds = ("wide" if each in _WIDE else "narrow" if each in _NARROW else "usual" for each in text)
    return sum(_WIDTHS_PX[kind] for kind in kinds)
