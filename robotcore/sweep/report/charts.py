"""The charts of the report: shares of verified runs, times of milestones, and conditions of failing runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from xml.etree.ElementTree import Element

from robotcore.sweep.failure_analysis import Split
from robotcore.sweep.record import GroupKey, Record
from robotcore.sweep.report.drawing import (
    Point,
    SvgAxis,
    dot,
    element,
    group,
    line,
    measure_labels,
    polyline,
    render_svg,
    text,
)
from robotcore.sweep.report.series import Series
from robotcore.sweep.statistics import Group, subsample
from robotcore.sweep.tables import format_verified

WIDTH, HEIGHT = 460, 230
MAX_STEPS = 200
"""The maximum number of steps of a curve. More could not be distinguished."""

MAX_MARKS = 300
"""The maximum number of marks in a row of a condition's chart. More would merge into a bar."""

_LEFT, _RIGHT, _TOP, _FOOT = 54, 14, 10, 26
_BAR, _GAP = 11, 18
_SUCCESS_ROW, _SUCCESS_TOP = 26, 8
_RUG_LEFT, _RUG_TOP, _RUG_FOOT, _RUG_ROW, _RUG_MARK = 64, 4, 24, 22, 16
_RUG_BOTTOM = _RUG_TOP + 2 * _RUG_ROW


def plot_success(groups: Sequence[Group]) -> str:
    """Return the chart of the shares of verified runs as SVG; an empty text if no run could be verified.

    Each group has a row: a dot at the share, a bar for its 95 % interval, and the number of verified runs. A group
    whose runs could not be verified has neither dot nor bar.
    """
    if all(each.verified is None for each in groups):
        return ""
    right = WIDTH - measure_labels(map(format_verified, groups))
    axis = SvgAxis(0, 100, measure_labels(each.name for each in groups), right)
    bottom = _SUCCESS_TOP + _SUCCESS_ROW * len(groups)
    rows = (
        group(_draw_share(each, axis, _SUCCESS_TOP + _SUCCESS_ROW * (index + 0.5)), class_="success")
        for index, each in enumerate(groups)
    )
    grid = axis.draw_grid(_SUCCESS_TOP, bottom, _format_percent)
    description = "Verified runs: " + ", ".join(f"{each.name} {format_verified(each)}" for each in groups)
    return render_svg(WIDTH, bottom + _FOOT, description, [grid, *rows])


def _draw_share(each: Group, axis: SvgAxis, y: float) -> Iterator[Element]:
    yield axis.draw_label(y, each.name)
    if each.verified_share is not None and each.verified_95 is not None:
        low, high = (axis.at(100 * edge) for edge in each.verified_95)
        yield line((low, y), (high, y), class_="interval")
        yield dot((axis.at(100 * each.verified_share), y), 3.5)
    yield text((axis.end + 12, y + 4), format_verified(each))


def _format_percent(value: float) -> str:
    return f"{value:.0f}\N{NO-BREAK SPACE}%"


def _format_seconds(value: float) -> str:
    return f"{value:g}\N{NO-BREAK SPACE}s"


def plot_arrivals(series: Sequence[Series], milestone: str) -> str:
    """Return a chart as SVG with a curve for each group: the share of runs that reached a milestone, over time."""
    time = _make_time_axis(series, [milestone], _LEFT)
    share = SvgAxis(0, 100, HEIGHT - _FOOT, _TOP)
    counts = (f"{each.group.name} {len(each.list_times(milestone))} of {each.group.runs}" for each in series)
    parts = [
        time.draw_grid(_TOP, HEIGHT - _FOOT, _format_seconds),
        group(_draw_share_axis(share), class_="axis"),
        *(polyline(_make_steps(each, time, share, milestone), class_=f"curve {each.style}") for each in series),
    ]
    return render_svg(WIDTH, HEIGHT, f"Share of runs that reached {milestone}, over time: {', '.join(counts)}", parts)


def _draw_share_axis(share: SvgAxis) -> Iterator[Element]:
    for value in share.list_ticks(4):
        y = share.at(value)
        yield line((_LEFT, y), (WIDTH - _RIGHT, y))
        yield text((_LEFT - 8, y + 4), _format_percent(value), text_anchor="end")


def _make_steps(each: Series, time: SvgAxis, share: SvgAxis, milestone: str) -> Iterator[Point]:
    """Yield the corners of a curve: an empirical distribution function up to the right edge of the chart."""
    reached = 0.0
    yield time.start, share.at(reached)
    counted = list(enumerate(each.list_times(milestone), start=1))
    for count, moment in [*subsample(counted, MAX_STEPS), *counted[-1:]]:
        yield time.at(moment), share.at(reached)
        reached = 100 * count / each.group.runs
        yield time.at(moment), share.at(reached)
    yield time.end, share.at(reached)


def plot_milestones(series: Sequence[Series], milestones: Sequence[str]) -> str:
    """Return the chart of the times of milestones as SVG.

    A dot is the median time of a group, and a bar goes from the 10 % to the 90 % quantile. A milestone that every run
    reaches at 0 s is left out.
    """
    milestones = [name for name in milestones if any(time > 0 for each in series for time in each.list_times(name))]
    time = _make_time_axis(series, milestones, measure_labels(milestones))
    tall = _BAR * len(series) + _GAP
    bottom = _TOP + tall * len(milestones)
    grid = time.draw_grid(_TOP, bottom, _format_seconds)
    rows = (
        group(_draw_milestone(series, name, time, _TOP + index * tall, tall)) for index, name in enumerate(milestones)
    )
    description = "Time to each milestone. The table below has the numbers"
    return render_svg(WIDTH, bottom + _FOOT, description, [grid, *rows])


def _make_time_axis(series: Sequence[Series], milestones: Sequence[str], start: float) -> SvgAxis:
    slowest = max((time for each in series for name in milestones for time in each.list_times(name)), default=0.0)
    return SvgAxis(0, max(1.04 * slowest, 1.0), start, WIDTH - _RIGHT)


def _draw_milestone(series: Sequence[Series], name: str, time: SvgAxis, top: float, tall: float) -> Iterator[Element]:
    yield time.draw_label(top + tall / 2, name)
    for index, each in enumerate(series):
        if quantiles := each.compute_quantiles(name):
            fast, median, slow = map(time.at, quantiles)
            y = top + _GAP / 2 + _BAR * (index + 0.5)
            yield line((fast, y), (slow, y), class_=f"interval {each.style}")
            yield dot((median, y), 4, class_=each.style)


def plot_condition(split: Split, records: Iterable[Record]) -> str:
    """Return the chart of a condition as SVG; an empty text if the condition's values are words.

    Each run has a mark at its value of the condition: passing runs in the upper row, failing runs in the lower row.

    split: the significant split of the condition. The side on which more runs fail is highlighted.
    records: the records of the sweep, also of other backends and worlds.
    """
    if isinstance(split.value, str):
        return ""
    values: dict[bool, list[float]] = {False: [], True: []}
    for record in records:
        value = record.result.conditions.get(split.condition)
        if GroupKey.from_record(record) == split.group and value is not None and not isinstance(value, str):
            values[record.is_failure].append(value)
    both = values[False] + values[True]
    axis = SvgAxis(min(both), max(both), _RUG_LEFT, WIDTH - _RIGHT)
    threshold = axis.at(split.value)
    left, right = (axis.start, threshold) if split.sign == "<" else (threshold, axis.end)
    parts = [
        axis.draw_grid(_RUG_TOP, _RUG_BOTTOM, lambda value: f"{value:g}"),
        element("rect", x=left, y=_RUG_TOP, width=right - left, height=_RUG_BOTTOM - _RUG_TOP, class_="side"),
        group(_draw_rug("passed", values[False], axis, _RUG_TOP), class_="rug passing"),
        group(_draw_rug("failed", values[True], axis, _RUG_TOP + _RUG_ROW), class_="rug failing"),
    ]
    description = f"{split.condition} of passing runs and of failing runs: {split}"
    return render_svg(WIDTH, _RUG_BOTTOM + _RUG_FOOT, description, parts)


def _draw_rug(name: str, values: Sequence[float], axis: SvgAxis, top: float) -> Iterator[Element]:
    yield axis.draw_label(top + _RUG_ROW / 2, name)
    for value in subsample(sorted(values), MAX_MARKS):
        x, margin = axis.at(value), (_RUG_ROW - _RUG_MARK) / 2
        yield line((x, top + margin), (x, top + margin + _RUG_MARK))
