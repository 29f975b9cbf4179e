"""Format the profile of a run for a terminal."""

from __future__ import annotations

import linecache
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from robotcore.runtime.profiler import AppLine, DeviceTimes, Profiler
from robotcore.runtime.result import RunResult
from robotcore.text import escape
from robotcore.view.text import build_table

ROWS = 10
"""The greatest number of devices and of lines in a profile."""

CODE_WIDTH = 60
"""The width of a line of code, in characters."""


def format_profile(result: RunResult, profiler: Profiler) -> RenderableType:
    """Return three tables: the phases of a tick, the slowest devices, and the slowest lines of the app.

    A table without values is left out, such as that of the phases of a run that ended in its first tick.
    """
    parts: list[RenderableType] = []
    if result.tick_times_us:
        parts += [Text(), _build_phase_table(result.tick_times_us)]
    if profiler.layer.times:
        parts += [Text(), _build_device_table(profiler.layer.times)]
    if profiler.line_s:
        parts += [Text(), _build_line_table(profiler.line_s)]
    return Group(*parts)


def _build_phase_table(times_us: Mapping[str, Mapping[str, float]]) -> Table:
    rows = ((phase, *(f"{each / 1e3:.3f}" for each in times.values())) for phase, times in times_us.items())
    return _build_table(("phase of a tick", "median ms", "99 % ms", "worst ms"), rows)


def _build_device_table(times: Mapping[str, DeviceTimes]) -> Table:
    slowest = sorted(times.items(), key=lambda item: -item[1].total_s)[:ROWS]
    rows = (
        (
            name,
            str(each.calls),
            f"{each.total_s:.3f}",
            f"{each.total_s / each.calls * 1e3:.3f}",
            f"{each.worst_s * 1e3:.3f}",
        )
        for name, each in slowest
    )
    return _build_table(("device", "calls", "total s", "mean ms", "worst ms"), rows)


def _build_line_table(seconds: Mapping[AppLine, float]) -> Table:
    lines: dict[tuple[str, int], dict[str, float]] = {}
    for line, each_s in seconds.items():
        lines.setdefault((line.file, line.number), {})[line.call] = each_s
    whole = sum(seconds.values())
    slowest = sorted(lines.items(), key=lambda item: -sum(item[1].values()))[:ROWS]
    rows = ((place, sum(calls.values()), max(calls, key=lambda call: calls[call])) for place, calls in slowest)
    table = _build_table(
        ("line of the app", "total s", "share", "mostly in", "code"),
        (
            (f"{Path(file).name}:{number}", f"{total_s:.3f}", f"{total_s / whole:.0%}", call, _read_code(file, number))
            for (file, number), total_s, call in rows
        ),
    )
    for column in table.columns[3:]:
        column.justify = "left"
    return table


def _read_code(file: str, number: int) -> str:
    return linecache.getline(file, number).strip()[:CODE_WIDTH]


def _build_table(titles: Sequence[str], rows: Iterable[Sequence[str]]) -> Table:
    table = build_table()
    for number, title in enumerate(titles):
        table.add_column(title, style="" if number else "cyan", justify="right" if number else "left", no_wrap=True)
    for row in rows:
        table.add_row(*map(escape, row))
    return table
