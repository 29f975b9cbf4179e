"""When runs arrive: the share that is there by then, and the time to each milestone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from xml.etree.ElementTree import Element

from robotcore.sweep.report.axis import Axis, below, label, room_for
from robotcore.sweep.report.series import Series, Spread
from robotcore.sweep.report.svg import Point, dot, drawing, group, line, text, trail
from robotcore.sweep.thinning import thinned

WIDTH, HEIGHT = 460, 230
MAX_STEPS = 200
"""A curve's steps; more of them cannot be told apart."""

_LEFT, _RIGHT, _TOP, _FOOT = 54, 14, 10, 26
_BAR = 11
_GAP = 18


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
