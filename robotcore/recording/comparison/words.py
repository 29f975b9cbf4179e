"""Two recordings as a table, side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import PurePath

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from robotcore.geometry import wrap_angle
from robotcore.recording.comparison.comparison import Comparison
from robotcore.recording.comparison.side import Side
from robotcore.recording.path import Path, length_of
from robotcore.text import counted, escape
from robotcore.view.summary import heading

NOTHING = "–"
ROOMS_DIFFER = "the rooms differ: poses and paths are not of one place"
Row = tuple[str, str, str]


def told(comparison: Comparison) -> RenderableType:
    """Return whether two recordings tell the same, and what they are measured by."""
    verdict = Text("alike", "bold green") if comparison.is_alike else Text("differ", "bold red")
    verdict += Text(f"  {escape(_finding(comparison))}")
    parting = Text(f"  {escape(_parting(comparison))}")
    if comparison.do_rooms_differ:
        parting += Text(f"\n  {ROOMS_DIFFER}")
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, header_style="bold")
    for index, title in enumerate(("", *titles(comparison))):
        table.add_column(escape(title), style="" if index else "cyan")
    for row in rows(comparison):
        table.add_row(*map(escape, row))
    return Group(verdict, parting, Text(), table)


def titles(comparison: Comparison) -> tuple[str, str]:
    """Return what to call the two: their files, without the folders where that tells them apart."""
    names = comparison.first.name, comparison.second.name
    first, second = (PurePath(name).name for name in names)
    return names if first == second else (first, second)


def rows(comparison: Comparison) -> Iterator[Row]:
    """Yield what is compared, and both sides of it."""
    one, other = comparison.first, comparison.second
    yield "run", heading(one.result), heading(other.result)
    yield "outcome", one.outcome, other.outcome
    first, second = comparison.milestones
    for name in dict.fromkeys((*first, *second)):
        yield name, _seconds(first.get(name)), _seconds(second.get(name))
    yield "time", _seconds(one.result.sim_time_s), _seconds(other.result.sim_time_s)
    yield "path by odometry", _metres(one.odometry), _metres(other.odometry)
    if one.truth and other.truth:
        yield "true path", _metres(one.truth), _metres(other.truth)
    yield "ends at", _pose(one), _pose(other)
    if one.drift is not None or other.drift is not None:
        yield "odometry off by", _drift(one), _drift(other)
    batteries = one.result.batteries, other.result.batteries
    for name in dict.fromkeys((*batteries[0], *batteries[1])):
        yield f"{name}, lowest", _volts(batteries[0].get(name)), _volts(batteries[1].get(name))
    yield "interventions", str(one.interventions), str(other.interventions)
    yield "loop", _loop(one), _loop(other)


def _finding(comparison: Comparison) -> str:
    if pair := comparison.first_other_milestone:
        return _other_milestone(comparison, *pair)
    if not comparison.is_alike:
        return f"the same milestones, but {comparison.first.outcome} against {comparison.second.outcome}"
    return "the same milestones in the same order, and the same outcome"


def _other_milestone(comparison: Comparison, first: str | None, second: str | None) -> str:
    if first and second:
        return f"the first milestone that differs: {first} against {second}"
    ahead, behind = titles(comparison) if first else reversed(titles(comparison))
    return f"{ahead} reaches {first or second}, {behind} does not"


def _parting(comparison: Comparison) -> str:
    if (parting := comparison.parting) is None:
        return "their states are the same in every tick"
    states = [repr(state) if state else "over" for state in (parting.first, parting.second)]
    return f"their states part in tick {parting.tick}, at {parting.time_s:.2f} s: {states[0]} against {states[1]}"


def _seconds(time: float | None) -> str:
    return NOTHING if time is None else f"{time:.2f} s"


def _volts(told: Mapping[str, float] | None) -> str:
    return f"{told['lowest_v']:.2f} V" if told else NOTHING


def _metres(path: Path) -> str:
    return f"{length_of(path.values()):.3f} m" if path else NOTHING


def _pose(side: Side) -> str:
    if not side.path:
        return NOTHING
    pose = side.path[-1]
    return f"{pose.x:.2f} m, {pose.y:.2f} m, {wrap_angle(pose.heading):.2f} rad"


def _drift(side: Side) -> str:
    return NOTHING if side.drift is None else f"{side.drift:.3f} m"


def _loop(side: Side) -> str:
    rate = NOTHING if side.rate_hz is None else f"{side.rate_hz:.2f} Hz"
    return f"{rate}, {counted(side.result.overruns, 'overrun')}"
