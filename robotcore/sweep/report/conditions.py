"""How a condition parts failing runs from passing ones."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from xml.etree.ElementTree import Element

from robotcore.sweep.explain import Finding
from robotcore.sweep.place import Place
from robotcore.sweep.record import Record
from robotcore.sweep.report.axis import Axis, below, label
from robotcore.sweep.report.svg import drawing, element, group, line
from robotcore.sweep.thinning import thinned

WIDTH = 460
MAX_MARKS = 300
"""A row's marks, evenly chosen; more of them run together."""

_LEFT, _RIGHT, _TOP, _FOOT = 64, 14, 4, 24
_ROW, _MARK = 22, 16
_BOTTOM = _TOP + 2 * _ROW


def condition_plot(finding: Finding, records: Iterable[Record]) -> str:
    """Return a mark for each run of the finding's place where its condition was, failing ones below.

    Empty where the condition is a word.
    """
    passing, failing = _values((each for each in records if Place.of(each) == finding.place), finding.condition)
    if isinstance(finding.split.value, str):
        return ""
    axis = Axis(min(passing + failing), max(passing + failing), _LEFT, WIDTH - _RIGHT)
    told = f"{finding.condition} of passing runs and of failing ones; {finding}"
    parts = [
        below(axis, _TOP, _BOTTOM, lambda value: f"{value:g}"),
        _side(finding.split.sign, axis.at(finding.split.value)),
        group(_rug("passed", passing, axis, _TOP), class_="rug passing"),
        group(_rug("failed", failing, axis, _TOP + _ROW), class_="rug failing"),
    ]
    return drawing(WIDTH, _BOTTOM + _FOOT, told, parts)


def _values(records: Iterable[Record], condition: str) -> tuple[list[float], list[float]]:
    """Return the condition's numbers in passing runs and in failing ones, in order."""
    passing: list[float] = []
    failing: list[float] = []
    for record in records:
        value = record.result.conditions.get(condition)
        if value is not None and not isinstance(value, str):
            (failing if record.is_failure else passing).append(value)
    return sorted(passing), sorted(failing)


def _side(sign: str, threshold: float) -> Element:
    """Return the ground of the side on which more runs fail."""
    left, right = (_LEFT, threshold) if sign == "<" else (threshold, WIDTH - _RIGHT)
    return element("rect", x=left, y=_TOP, width=right - left, height=_BOTTOM - _TOP, class_="side")


def _rug(name: str, values: Sequence[float], axis: Axis, top: float) -> Iterator[Element]:
    yield label(axis, top + _ROW / 2, name)
    for value in thinned(values, MAX_MARKS):
        x, margin = axis.at(value), (_ROW - _MARK) / 2
        yield line((x, top + margin), (x, top + margin + _MARK))
