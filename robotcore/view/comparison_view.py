"""Show the comparison of two recordings as a table and as a picture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import PurePath
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from robotcore.canvas import BAD, FADED, GOOD, INK, RULE, Canvas, Colour, measure_text, shorten_text
from robotcore.geometry import wrap_angle
from robotcore.optics import Image
from robotcore.recording.run_comparison import Comparison, RunSummary
from robotcore.text import escape, pluralize
from robotcore.view.overhead import MapPath, draw_map
from robotcore.view.page import EDGE, MAP, SIDE, TOP, WIDTH, begin_page, finish_page, join_titles
from robotcore.view.picture import build_figure, build_world
from robotcore.view.text import build_table, format_heading

FIRST: Colour = (36, 99, 235)
SECOND: Colour = (235, 94, 20)
_COLUMNS = (SIDE, SIDE + 176, SIDE + 420)
_COLUMN_WIDTH = 230
_LINE, _ROW = 22, 16
_TEXT_PX = 13


def draw_comparison(comparison: Comparison) -> Image:
    """Return the picture of a comparison: BGR, 1600 pixels wide and 1000 high.

    It shows the paths of both recordings in the world of the first one.
    """
    verdict, colour = ("alike", GOOD) if comparison.is_alike else ("differ", BAD)
    words = "the rooms differ: the map shows the room of the first run" if comparison.has_other_room else ""
    canvas = begin_page(join_titles(*build_titles(comparison)), verdict, colour, words)
    _draw_table(canvas, comparison)
    figures = [build_figure(summary.recording) for summary in (comparison.first, comparison.second)]
    paths = [
        MapPath(figure.robot, figure.track, figure.result.milestones, dict.fromkeys(figure.track.states, colour))
        for figure, colour in zip(figures, (FIRST, SECOND), strict=True)
    ]
    points = [step for figure in figures for step in figure.track.points]
    return finish_page(canvas, draw_map(build_world(comparison.first.recording, points), paths, MAP))


def _draw_table(canvas: Canvas, comparison: Comparison) -> None:
    y = TOP + 20.0
    for name, colour, x in zip(build_titles(comparison), (FIRST, SECOND), _COLUMNS[1:], strict=True):
        canvas.draw_line([(x, y - 6), (x + 40, y - 6)], colour, 7)
        title = shorten_text(name, _COLUMN_WIDTH - 52, _TEXT_PX, bold=True)
        canvas.write_text((x + 52, y), title, INK, _TEXT_PX, bold=True)
    canvas.draw_line([(SIDE, y + 14), (WIDTH - EDGE, y + 14)], RULE, 1)
    y += _LINE + _ROW
    for name, *texts in build_rows(comparison):
        canvas.write_text((_COLUMNS[0], y), name, FADED, _TEXT_PX)
        cells = [_wrap_to_column(words.replace("–", "-")) for words in texts]
        for lines, x in zip(cells, _COLUMNS[1:], strict=True):
            for index, line in enumerate(lines):
                canvas.write_text((x, y + index * _LINE), line, INK, _TEXT_PX)
        y += max(map(len, cells)) * _LINE + _ROW


def _wrap_to_column(words: str) -> list[str]:
    lines: list[str] = []
    for word in words.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and measure_text(longer, _TEXT_PX) <= _COLUMN_WIDTH:
            lines[-1] = longer
        else:
            lines.append(shorten_text(word, _COLUMN_WIDTH, _TEXT_PX))
    return lines


NOTHING = "–"
ROOMS_DIFFER = "the rooms differ: poses and paths cannot be compared"
Row = tuple[str, str, str]


def format_comparison(comparison: Comparison) -> RenderableType:
    """Return the comparison for a terminal: the verdict, the first difference, and a table of measurements."""
    verdict = Text("alike", "bold green") if comparison.is_alike else Text("differ", "bold red")
    verdict += Text(f"  {escape(_format_finding(comparison))}")
    first_difference = Text(f"  {escape(_format_state_difference(comparison))}")
    if comparison.has_other_room:
        first_difference += Text(f"\n  {ROOMS_DIFFER}")
    table = build_table()
    for index, title in enumerate(("", *build_titles(comparison))):
        table.add_column(escape(title), style="" if index else "cyan")
    for row in build_rows(comparison):
        table.add_row(*map(escape, row))
    return Group(verdict, first_difference, Text(), table)


def build_titles(comparison: Comparison) -> tuple[str, str]:
    """Return the names of both files, with their folders if the names are equal."""
    names = comparison.first.name, comparison.second.name
    first, second = (PurePath(name).name for name in names)
    return names if first == second else (first, second)


_MEASURES = {
    "time": ("time_s", "{:.2f} s"),
    "path by odometry": ("odometry_m", "{:.3f} m"),
    "true path": ("truth_m", "{:.3f} m"),
    "ends at": ("end", "{}"),
    "odometry off by": ("drift_m", "{:.3f} m"),
}
"""The rows of measurements: the key in `RunSummary.to_dict`, and the format of the value, by the title of the row."""


def build_rows(comparison: Comparison) -> Iterator[Row]:
    """Yield the rows of the table. Each has the name of a measurement, and its values in the first and second run.

    A measurement that neither run has is left out.
    """
    runs = [_summarise(each) for each in (comparison.first, comparison.second)]
    yield _build_row("run", "{}", (each["heading"] for each in runs))
    for title in ("settings", "faults"):
        if any(each[title] for each in runs):
            yield _build_row(title, "{}", (each[title] or None for each in runs))
    yield _build_row("outcome", "{}", (each["outcome"] for each in runs))
    for name in dict.fromkeys(chain(*comparison.milestones)):
        yield _build_row(name, "{:.2f} s", (reached.get(name) for reached in comparison.milestones))
    for title, (key, form) in _MEASURES.items():
        if any(each[key] is not None for each in runs):
            yield _build_row(title, form, (each[key] for each in runs))
    for name in dict.fromkeys(chain(*(each["batteries"] for each in runs))):
        batteries = (each["batteries"].get(name) for each in runs)
        yield _build_row(f"{name}, lowest", "{0[lowest_v]:.2f} V", batteries)
    yield _build_row("interventions", "{}", (each["interventions"] for each in runs))
    yield _build_row("loop", "{}", (each["loop"] for each in runs))


def _summarise(run: RunSummary) -> dict[str, Any]:
    values = run.to_dict()
    end, rate = values["final_truth"] or values["final_odometry"], values["rate_hz"]
    return values | {
        "heading": format_heading(run.result),
        "settings": ", ".join(f"{name}={value}" for name, value in values["settings"].items()),
        "faults": "; ".join(values["faults"]),
        "end": end and f"{end[0]:.2f} m, {end[1]:.2f} m, {wrap_angle(end[2]):.2f} rad",
        "loop": f"{NOTHING if rate is None else f'{rate:.2f} Hz'}, {pluralize(values['overruns'], 'overrun')}",
    }


def _build_row(title: str, form: str, values: Iterable[Any]) -> Row:
    first, second = (NOTHING if value is None else form.format(value) for value in values)
    return title, first, second


def _format_finding(comparison: Comparison) -> str:
    if pair := comparison.first_other_milestone:
        return _format_milestone_difference(comparison, *pair)
    if not comparison.is_alike:
        return f"the same milestones, but the outcomes {comparison.first.outcome} and {comparison.second.outcome}"
    return "the same milestones in the same order, and the same outcome"


def _format_milestone_difference(comparison: Comparison, first: str | None, second: str | None) -> str:
    if first and second:
        return f"the first milestones that differ: {first} and {second}"
    ahead, behind = build_titles(comparison) if first else reversed(build_titles(comparison))
    return f"{ahead} reaches {first or second}, and {behind} does not"


def _format_state_difference(comparison: Comparison) -> str:
    if (first := comparison.first_difference) is None:
        return "the states are the same in every tick"
    states = [repr(state) if state else "ended" for state in (first.first, first.second)]
    return f"the states first differ in tick {first.tick}, at {first.time_s:.2f} s: {states[0]} and {states[1]}"
