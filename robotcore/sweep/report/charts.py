"""The charts of the report: shares of verified runs, times of milestones, and conditions of failing runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from xml.etree.ElementTree import Element

from robotcore.sweep.failure_analysis import SignificantSplit
from robotcore.sweep.record import GroupKey, Record
from robotcore.sweep.report.drawing import (
    Axis,
    Point,
    dot,
    draw_axis,
    draw_label,
    element,
    group,
    line,
    measure_labels,
    polyline,
    render_svg,
    text,
)
from robotcore.sweep.report.series import Series, Spread
from robotcore.sweep.statistics import Group, subsample
from robotcore.sweep.tables import format_verified

_SUCCESS_ROW, _SUCCESS_TOP, _SUCCESS_FOOT = 26, 8, 26

WIDTH, HEIGHT = 460, 230
MAX_STEPS = 200
"""The maximum number of steps of a curve. More could not be distinguished."""

_LEFT, _RIGHT, _TOP, _FOOT = 54, 14, 10, 26
_BAR = 11
_GAP = 18

MAX_MARKS = 300
"""The maximum number of marks in a row of a condition's chart. More would merge into a bar."""

_RUG_LEFT, _RUG_TOP, _RUG_FOOT = 64, 4, 24
_RUG_ROW, _RUG_MARK = 22, 16
_RUG_BOTTOM = _RUG_TOP + 2 * _RUG_ROW


def plot_success(groups: Sequence[Group]) -> str:
    """Return the chart of the shares of verified runs as SVG; an empty text if no run could be verified.

    Each group has a row: a dot at the share, a bar for its 95 % interval, and the number of verified runs. A group
    whose runs could not be verified has neither dot nor bar.
    """
    if all(each.verified is None for each in groups):
        return ""
    axis = Axis(
        0, 100, measure_labels(each.name for each in groups), WIDTH - measure_labels(map(format_verified, groups))
    )
    bottom = _SUCCESS_TOP + _SUCCESS_ROW * len(groups)
    rows = (_draw_row(each, axis, _SUCCESS_TOP + _SUCCESS_ROW * (index + 0.5)) for index, each in enumerate(groups))
    grid = draw_axis(axis, _SUCCESS_TOP, bottom, lambda share: f"{share:.0f}\N{NO-BREAK SPACE}%")
    return render_svg(WIDTH, bottom + _SUCCESS_FOOT, _describe_shares(groups), [grid, *rows])


def _draw_row(each: Group, axis: Axis, y: float) -> Element:
    return group(_draw_marks(each, axis, y), class_="success")


def _draw_marks(each: Group, axis: Axis, y: float) -> Iterator[Element]:
    yield draw_label(axis, y, each.name)
    if each.verified_share is not None and each.verified_95 is not None:
        low, high = (axis.at(100 * edge) for edge in each.verified_95)
        yield line((low, y), (high, y), class_="interval")
        yield dot((axis.at(100 * each.verified_share), y), 3.5)
    yield text((axis.end + 12, y + 4), format_verified(each))


def _describe_shares(groups: Sequence[Group]) -> str:
    return "Verified runs: " + ", ".join(f"{each.name} {format_verified(each)}" for each in groups)


def plot_arrivals(series: Sequence[Series], milestone: str) -> str:
    """Return a chart as SVG with a curve for each group: the share of runs that reached a milestone, over time."""
    time = _make_time_axis(series, [milestone], _LEFT)
    share = Axis(0, 100, HEIGHT - _FOOT, _TOP)
    curves = [_draw_curve(each, time, share, milestone) for each in series]
    description = f"Share of runs that reached {milestone}, over time: " + ", ".join(
        f"{each.group.name} {len(each.list_times(milestone))} of {each.group.runs}" for each in series
    )
    grid = draw_axis(time, _TOP, HEIGHT - _FOOT, _format_seconds)
    return render_svg(WIDTH, HEIGHT, description, [grid, group(_draw_share_axis(share), class_="axis"), *curves])


def plot_milestones(series: Sequence[Series], milestones: Sequence[str]) -> str:
    """Return the chart of the times of milestones as SVG.

    A dot is the median time of a group, and a bar goes from the 10 % to the 90 % quantile. A milestone that every run
    reaches at 0 s is left out.
    """
    milestones = [name for name in milestones if any(time > 0 for each in series for time in each.list_times(name))]
    time = _make_time_axis(series, milestones, measure_labels(milestones))
    tall = _BAR * len(series) + _GAP
    bottom = _TOP + tall * len(milestones)
    grid = draw_axis(time, _TOP, bottom, _format_seconds)
    rows = (
        group(_draw_milestone(series, name, time, _TOP + index * tall, tall)) for index, name in enumerate(milestones)
    )
    description = "Time to each milestone. The table below has the numbers"
    return render_svg(WIDTH, bottom + _FOOT, description, [grid, *rows])


def _make_time_axis(series: Sequence[Series], milestones: Sequence[str], start: float) -> Axis:
    slowest = max((time for each in series for name in milestones for time in each.list_times(name)), default=0.0)
    return Axis(0, max(1.04 * slowest, 1.0), start, WIDTH - _RIGHT)


def _format_seconds(value: float) -> str:
    return f"{value:g}\N{NO-BREAK SPACE}s"


def _draw_share_axis(share: Axis) -> Iterator[Element]:
    for value in share.list_ticks(4):
        y = share.at(value)
        yield line((_LEFT, y), (WIDTH - _RIGHT, y))
        yield text((_LEFT - 8, y + 4), f"{value:.0f}\N{NO-BREAK SPACE}%", text_anchor="end")


def _draw_curve(each: Series, time: Axis, share: Axis, milestone: str) -> Element:
    return polyline(_make_steps(each, time, share, milestone), class_=f"curve {each.style}")


def _make_steps(each: Series, time: Axis, share: Axis, milestone: str) -> Iterator[Point]:
    """Yield the corners of a curve: an empirical distribution function up to the right edge of the chart."""
    reached = 0.0
    yield time.start, share.at(reached)
    counted = list(enumerate(each.list_times(milestone), start=1))
    for count, moment in [*subsample(counted, MAX_STEPS), *counted[-1:]]:
        yield time.at(moment), share.at(reached)
        reached = 100 * count / each.group.runs
        yield time.at(moment), share.at(reached)
    yield time.end, share.at(reached)


def _draw_milestone(series: Sequence[Series], name: str, time: Axis, top: float, tall: float) -> Iterator[Element]:
    yield draw_label(time, top + tall / 2, name)
    for index, each in enumerate(series):
        if spread := Spread.of(each.list_times(name)):
            y = top + _GAP / 2 + _BAR * (index + 0.5)
            yield line((time.at(spread.fast), y), (time.at(spread.slow), y), class_=f"interval {each.style}")
            yield dot((time.at(spread.median), y), 4, class_=each.style)


def plot_condition(significant: SignificantSplit, records: Iterable[Record]) -> str:
    """Return the chart of a condition as SVG; an empty text if the condition's values are words.

    Each run has a mark at its value of the condition: passing runs in the upper row, failing runs in the lower row.

    significant: the significant split of the condition. The side on which more runs fail is highlighted.
    records: the records of the sweep, also of other backends and worlds.
    """
    passing, failing = _split_values(
        (each for each in records if GroupKey.of(each) == significant.group), significant.condition
    )
    if isinstance(significant.split.value, str):
        return ""
    axis = Axis(min(passing + failing), max(passing + failing), _RUG_LEFT, WIDTH - _RIGHT)
    description = f"{significant.condition} of passing runs and of failing runs: {significant}"
    parts = [
        draw_axis(axis, _RUG_TOP, _RUG_BOTTOM, lambda value: f"{value:g}"),
        _draw_failing_side(significant.split.sign, axis.at(significant.split.value)),
        group(_draw_rug("passed", passing, axis, _RUG_TOP), class_="rug passing"),
        group(_draw_rug("failed", failing, axis, _RUG_TOP + _RUG_ROW), class_="rug failing"),
    ]
    return render_svg(WIDTH, _RUG_BOTTOM + _RUG_FOOT, description, parts)


def _split_values(records: Iterable[Record], condition: str) -> tuple[list[float], list[float]]:
    passing: list[float] = []
    failing: list[float] = []
    for record in records:
        value = record.result.conditions.get(condition)
        if value is not None and not isinstance(value, str):
            (failing if record.is_failure else passing).append(value)
    return sorted(passing), sorted(failing)


def _draw_failing_side(sign: str, threshold: float) -> Element:
    left, right = (_RUG_LEFT, threshold) if sign == "<" else (threshold, WIDTH - _RIGHT)
    return element("rect", x=left, y=_RUG_TOP, width=right - left, height=_RUG_BOTTOM - _RUG_TOP, class_="side")


def _draw_rug(name: str, values: Sequence[float], axis: Axis, top: float) -> Iterator[Element]:
    yield draw_label(axis, top + _RUG_ROW / 2, name)
    for value in subsample(values, MAX_MARKS):
        x, margin = axis.at(value), (_RUG_ROW - _RUG_MARK) / 2
        yield line((x, top + margin), (x, top + margin + _RUG_MARK))
