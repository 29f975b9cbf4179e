"""Show how much simulations differ from a recorded run, as a table for a terminal."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import PurePath
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from robotcore.fidelity.fidelity import Fidelity
from robotcore.fidelity.measures import Differences, PathDifference, PictureDifference, RangeDifference, WheelDifference
from robotcore.recording.summary import build_result
from robotcore.text import escape, pluralize
from robotcore.view.text import build_table, format_heading

UNKNOWN = "–"

Row = tuple[str, ...]
"""The title of a measure, and its value in each column."""


def format_fidelity(fidelity: Fidelity) -> RenderableType:
    """Return the comparison for a terminal: the run, notes about it, and a table of the differences."""
    title = Text(escape(PurePath(fidelity.name).name), "bold") + Text(f"  {escape(build_heading(fidelity))}")
    run = fidelity.recorded.run
    lines = [f"{pluralize(len(run.times), 'tick')} in {fidelity.duration_s:.2f} s{_format_length(fidelity)}"]
    table = build_table()
    for index, name in enumerate(("", *list_titles(fidelity))):
        table.add_column(escape(name), style="" if index else "cyan")
    for row in build_rows(fidelity):
        table.add_row(*map(escape, row))
    return Group(title, *(Text(f"  {escape(line)}") for line in (*lines, *fidelity.notes)), Text(), table)


def build_heading(fidelity: Fidelity) -> str:
    """Return a heading such as ``green-search on raspberrypi, simulated by mujoco in my_room``."""
    world = fidelity.world.name if fidelity.world else "an empty floor"
    return f"{format_heading(build_result(fidelity.recording))}, simulated by {fidelity.backend} in {world}"


def _format_length(fidelity: Fidelity) -> str:
    path = fidelity.simulations[0].differences.path
    return f", {path.recorded_m:.2f} m" if path else ""


def list_titles(fidelity: Fidelity) -> list[str]:
    """Return the titles of the columns. A file has its name without the folder."""
    return [PurePath(each.title).name for each in fidelity.simulations]


def build_rows(fidelity: Fidelity) -> Iterator[Row]:
    """Yield the rows of the table. A measure that no column has is left out."""
    columns = [column.differences for column in fidelity.simulations]
    yield from _list_rows([each.path for each in columns], "path", _PATH)
    for part, measures in (("wheels", _WHEEL), ("ranges", _RANGE), ("pictures", _PICTURE)):
        for name in _list_names(columns, part):
            title = f"{name} wheel" if part == "wheels" else name
            yield from _list_rows([getattr(each, part).get(name) for each in columns], title, measures)


def _list_names(columns: Sequence[Differences], part: str) -> list[str]:
    return list(dict.fromkeys(name for each in columns for name in getattr(each, part)))


Measures = dict[str, Callable[[Any], str | None]]
"""The functions that format a measure, by its title. They return None for an unknown value."""


def _list_rows(found: Sequence[Any], name: str, measures: Measures) -> Iterator[Row]:
    for title, measure in measures.items():
        values = [measure(each) if each else None for each in found]
        if any(value is not None for value in values):
            yield f"{name}, {title}", *(UNKNOWN if value is None else value for value in values)


def _format_end(path: PathDifference) -> str:
    share = "" if path.end_m_per_m is None else f", {_format_share(path.end_m_per_m)} of the way"
    return f"{path.end_m:.3f} m{share}"


def _format_turn(path: PathDifference) -> str:
    share = "" if path.heading_rad_per_m is None else f", {math.degrees(path.heading_rad_per_m):.2f}° per metre"
    return f"{math.degrees(path.heading_rad):+.1f}°{share}"


def _format_share(share: float | None) -> str:
    return UNKNOWN if share is None else f"{100 * share:.1f} %"


_PATH: Measures = {
    "at the end": _format_end,
    "largest": lambda path: f"{path.largest_m:.3f} m",
    "mean": lambda path: f"{path.mean_m:.3f} m",
    "heading": _format_turn,
}


def _format_rms(wheel: WheelDifference) -> str:
    return f"{wheel.rms_rad_s:.3f} rad/s, {_format_share(wheel.rms_share)}"


def _format_largest(wheel: WheelDifference) -> str:
    return f"{wheel.largest_rad_s:.3f} rad/s, {_format_share(wheel.largest_share)}"


_WHEEL: Measures = {"RMS": _format_rms, "largest": _format_largest}


def _format_lost(measured: RangeDifference) -> str:
    lost = measured.recorded_lost_share, measured.simulated_lost_share
    return f"{_format_share(lost[0])} recorded, {_format_share(lost[1])} simulated"


_RANGE: Measures = {
    "median": lambda ranges: None if ranges.median_m is None else f"{ranges.median_m:.3f} m",
    "95 %": lambda ranges: None if ranges.p95_m is None else f"{ranges.p95_m:.3f} m",
    "no echo": _format_lost,
}


def _format_grey(pictures: PictureDifference) -> str:
    return f"{_format_share(pictures.grey_share)} of the range, {pluralize(pictures.pairs, 'picture')}"


_PICTURE: Measures = {
    "grey": _format_grey,
    "shift": lambda pictures: None if pictures.shift_px is None else f"{pictures.shift_px:.1f} px",
}
