"""The share of verified runs in each world, with its interval."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.etree.ElementTree import Element

from robotcore.sweep.report.axis import Axis, below, label, room_for
from robotcore.sweep.report.svg import dot, drawing, group, line, text
from robotcore.sweep.statistics import Group
from robotcore.sweep.words import verified_told

WIDTH = 460
_ROW, _TOP, _FOOT = 26, 8, 26


def success_plot(groups: Sequence[Group]) -> str:
    """Return a row for each group: a dot where its share is, a bar over its 95 % interval, the count beside it.

    Neither dot nor bar where nobody can judge. Empty where nobody can judge any group.
    """
    if all(each.verified is None for each in groups):
        return ""
    axis = Axis(0, 100, room_for(each.name for each in groups), WIDTH - room_for(map(verified_told, groups)))
    bottom = _TOP + _ROW * len(groups)
    rows = (_row(each, axis, _TOP + _ROW * (index + 0.5)) for index, each in enumerate(groups))
    grid = below(axis, _TOP, bottom, lambda share: f"{share:.0f}\N{NO-BREAK SPACE}%")
    return drawing(WIDTH, bottom + _FOOT, _words(groups), [grid, *rows])


def _row(each: Group, axis: Axis, y: float) -> Element:
    return group(_marks(each, axis, y), class_="success")


def _marks(each: Group, axis: Axis, y: float) -> Iterator[Element]:
    yield label(axis, y, each.name)
    if each.verified_share is not None and each.verified_95 is not None:
        low, high = (axis.at(100 * edge) for edge in each.verified_95)
        yield line((low, y), (high, y), class_="interval")
        yield dot((axis.at(100 * each.verified_share), y), 3.5)
    yield text((axis.end + 12, y + 4), verified_told(each))


def _words(groups: Sequence[Group]) -> str:
    return "Verified runs: " + ", ".join(f"{each.name} {verified_told(each)}" for each in groups)
