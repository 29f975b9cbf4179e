"""Charts of the report: verified share, times, and conditions of failing runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from xml.etree.ElementTree import Element

from robotcore.sweep.failure_analysis import Finding
from robotcore.sweep.record import Place, Record
from robotcore.sweep.report.drawing import (
    Axis,
    Point,
    below,
    dot,
    drawing,
    element,
    group,
    label,
    line,
    room_for,
    text,
    trail,
)
from robotcore.sweep.report.series import Series, Spread
from robotcore.sweep.statistics import Group, thinned
from robotcore.sweep.tables import verified_told

_SUCCESS_ROW, _SUCCESS_TOP, _SUCCESS_FOOT = 26, 8, 26

WIDTH, HEIGHT = 460, 230
MAX_STEPS = 200
"""A curve's steps; more of them cannot be told apart."""

_LEFT, _RIGHT, _TOP, _FOOT = 54, 14, 10, 26
_BAR = 11
_GAP = 18

MAX_MARKS = 300
"""A row's marks, evenly chosen; more of them run together."""

_RUG_LEFT, _RUG_TOP, _RUG_FOOT = 64, 4, 24
_RUG_ROW, _RUG_MARK = 22, 16
_RUG_BOTTOM = _RUG_TOP + 2 * _RUG_ROW


def success_plot(groups: Sequence[Group]) -> str:
    """Return a row for each group: a dot where its share is, a bar over its 95 % interval, the count beside it.

    Neither dot nor bar where nobody can judge. Empty where nobody can judge any group.
    """
    if all(each.verified is None for each in groups):
        return ""
    axis = Axis(0, 100, room_for(each.name for each in groups), WIDTH - room_for(map(verified_told, groups)))
    bottom = _SUCCESS_TOP + _SUCCESS_ROW * len(groups)
    rows = (_row(each, axis, _SUCCESS_TOP + _SUCCESS_ROW * (index + 0.5)) for index, each in enumerate(groups))
    grid = below(axis, _SUCCESS_TOP, bottom, lambda share: f"{share:.0f}\N{NO-BREAK SPACE}%")
    return drawing(WIDTH, bottom + _SUCCESS_FOOT, _words(groups), [grid, *rows])


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


def arrival_plot(series: Sequence[Series], milestone: str) -> str:
    """Return for each group the share of all its runs that have reached a milestone by a time."""
    time = _time_axis(series, [milestone], _LEFT)
    share = Axis(0, 100, HEIGHT - _FOOT, _TOP)
    curves = [_curve(each, time, share, milestone) for each in series]
    told = f"Share of runs that reached {milestone}, over time: " + ", ".join(
        f"{each.group.name} {len(each.arrivals(milestone))} of {each.group.runs}" for each in series
    )
    grid = below(time, _TOP, HEIGHT - _FOOT, _seconds)
    return drawing(WIDTH, HEIGHT, told, [grid, group(_shares(share), class_="axis"), *curves])


def milestone_plot(series: Sequence[Series], milestones: Sequence[str]) -> str:
    """Return, for each milestone and group, a bar over the middle 80 % of its times, and a dot at their median.

    A milestone that every run reaches at once is left out.
    """
    milestones = [name for name in milestones if any(time > 0 for each in series for time in each.arrivals(name))]
    time = _time_axis(series, milestones, room_for(milestones))
    tall = _BAR * len(series) + _GAP
    bottom = _TOP + tall * len(milestones)
    grid = below(time, _TOP, bottom, _seconds)
    rows = (group(_milestone(series, name, time, _TOP + index * tall, tall)) for index, name in enumerate(milestones))
    told = "Time to each milestone; the table below tells the figures"
    return drawing(WIDTH, bottom + _FOOT, told, [grid, *rows])


def _time_axis(series: Sequence[Series], milestones: Sequence[str], start: float) -> Axis:
    slowest = max((time for each in series for name in milestones for time in each.arrivals(name)), default=0.0)
    return Axis(0, max(1.04 * slowest, 1.0), start, WIDTH - _RIGHT)


def _seconds(value: float) -> str:
    return f"{value:g}\N{NO-BREAK SPACE}s"


def _shares(share: Axis) -> Iterator[Element]:
    for value in share.ticks(4):
        y = share.at(value)
        yield line((_LEFT, y), (WIDTH - _RIGHT, y))
        yield text((_LEFT - 8, y + 4), f"{value:.0f}\N{NO-BREAK SPACE}%", text_anchor="end")


def _curve(each: Series, time: Axis, share: Axis, milestone: str) -> Element:
    return trail(_steps(each, time, share, milestone), class_=f"curve {each.style}")


def _steps(each: Series, time: Axis, share: Axis, milestone: str) -> Iterator[Point]:
    """Yield the corners of an empirical distribution, on to the right edge."""
    reached = 0.0
    yield time.start, share.at(reached)
    counted = list(enumerate(each.arrivals(milestone), start=1))
    for count, moment in [*thinned(counted, MAX_STEPS), *counted[-1:]]:
        yield time.at(moment), share.at(reached)
        reached = 100 * count / each.group.runs
        yield time.at(moment), share.at(reached)
    yield time.end, share.at(reached)


def _milestone(series: Sequence[Series], name: str, time: Axis, top: float, tall: float) -> Iterator[Element]:
    yield label(time, top + tall / 2, name)
    for index, each in enumerate(series):
        if spread := Spread.of(each.arrivals(name)):
            y = top + _GAP / 2 + _BAR * (index + 0.5)
            yield line((time.at(spread.fast), y), (time.at(spread.slow), y), class_=f"interval {each.style}")
            yield dot((time.at(spread.median), y), 4, class_=each.style)


def condition_plot(finding: Finding, records: Iterable[Record]) -> str:
    """Return a mark for each run of the finding's place where its condition was, failing ones below.

    Empty where the condition is a word.
    """
    passing, failing = _values((each for each in records if Place.of(each) == finding.place), finding.condition)
    if isinstance(finding.split.value, str):
        return ""
    axis = Axis(min(passing + failing), max(passing + failing), _RUG_LEFT, WIDTH - _RIGHT)
    told = f"{finding.condition} of passing runs and of failing ones; {finding}"
    parts = [
        below(axis, _RUG_TOP, _RUG_BOTTOM, lambda value: f"{value:g}"),
        _side(finding.split.sign, axis.at(finding.split.value)),
        group(_rug("passed", passing, axis, _RUG_TOP), class_="rug passing"),
        group(_rug("failed", failing, axis, _RUG_TOP + _RUG_ROW), class_="rug failing"),
    ]
    return drawing(WIDTH, _RUG_BOTTOM + _RUG_FOOT, told, parts)


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
    left, right = (_RUG_LEFT, threshold) if sign == "<" else (threshold, WIDTH - _RIGHT)
    return element("rect", x=left, y=_RUG_TOP, width=right - left, height=_RUG_BOTTOM - _RUG_TOP, class_="side")


def _rug(name: str, values: Sequence[float], axis: Axis, top: float) -> Iterator[Element]:
    yield label(axis, top + _RUG_ROW / 2, name)
    for value in thinned(values, MAX_MARKS):
        x, margin = axis.at(value), (_RUG_ROW - _RUG_MARK) / 2
        yield line((x, top + margin), (x, top + margin + _RUG_MARK))
