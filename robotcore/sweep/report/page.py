"""The HTML page of the report. Its layout is in ``templates``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from datetime import datetime, timezone
from itertools import cycle, islice
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from robotcore.canvas import SERIES, Colour, lighten
from robotcore.compatibility import read_version
from robotcore.description import WorldDescription, load_world, world_names
from robotcore.runtime.result import RunResult
from robotcore.sweep.failure_analysis import explain, format_p
from robotcore.sweep.record import Record, classify_failure, format_failure
from robotcore.sweep.report import failures
from robotcore.sweep.report.charts import plot_arrivals, plot_condition, plot_milestones, plot_success
from robotcore.sweep.report.maps import draw_maps
from robotcore.sweep.report.series import Series, build_series, find_goal, list_milestones
from robotcore.sweep.spec import format_seeds
from robotcore.sweep.statistics import Group, Requirement, compare_backends, list_missed_requirements
from robotcore.sweep.tables import COLUMNS, format_judge

MAX_DIFFERING = 30
"""The maximum number of differing runs in the table of two backends."""

MAX_OPEN = 8
"""The maximum number of failing runs whose groups are unfolded when the page opens."""

_WHITE_SHARE = 0.42
"""The share of white, from 0 to 1, that is mixed into a colour for a dark page."""


def render_page(
    records: Sequence[Record],
    folder: Path,
    command: str,
    worlds: Sequence[WorldDescription],
    requirements: Sequence[Requirement],
) -> str:
    """Return the page of a report as HTML. The order of the records does not matter.

    The parameters are described at `write_report`.
    """
    loader = PackageLoader("robotcore.sweep.report")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    functions = (
        format_failure,
        format_p,
        failures.format_title,
        failures.list_facts,
        failures.list_conditions,
        failures.embed_picture,
    )
    environment.globals |= {function.__name__: function for function in functions}
    environment.globals |= {"max_differing": MAX_DIFFERING, "few": MAX_OPEN, "columns": COLUMNS}
    records = sorted(records, key=_sort_key)
    series = build_series(records)
    groups = [each.group for each in series]
    explanation = explain(records)
    return environment.get_template("page.html.j2").render(
        head=_describe_head(records, groups, folder),
        command_line=command,
        folder=folder,
        groups=groups,
        series=series,
        success=plot_success(groups),
        requirements=requirements,
        misses=list_missed_requirements(requirements, groups),
        agreements=compare_backends(records),
        maps=draw_maps(series, _load_worlds(series, worlds)),
        colours=compute_shades(["passing", "failing", *dict.fromkeys(each.style for each in series)]),
        endings=failures.count_endings(series),
        splits=explanation.splits,
        split_charts=[plot_condition(each, records) for each in explanation.splits],
        no_split=explanation.reason,
        failures=failures.choose_failures(records),
        **_plot_times(series),
    )


def _sort_key(record: Record) -> tuple[str, str, int]:
    result = record.result
    return result.world or "", result.backend, -1 if result.seed is None else result.seed


def _plot_times(series: Sequence[Series]) -> dict[str, Any]:
    milestones = list_milestones(series)
    goal = find_goal(series, milestones)
    return {
        "milestones": milestones,
        "goal": goal,
        "arrivals": plot_arrivals(series, goal) if goal else "",
        "passages": plot_milestones(series, milestones) if goal else "",
    }


def _load_worlds(series: Sequence[Series], worlds: Sequence[WorldDescription]) -> dict[str, WorldDescription]:
    shipped = set(world_names()) & {each.group.world for each in series}
    return {name: load_world(name) for name in shipped} | {world.name: world for world in worlds}


def compute_shades(names: Sequence[str]) -> list[dict[str, str]]:
    """Return a colour in CSS, such as ``#2463eb``, for each name: ``light`` on a light page, ``dark`` on a dark page.

    People with the common kinds of colour blindness can distinguish the colours.
    """
    return [
        {"light": _css(colour), "dark": _css(lighten(colour, _WHITE_SHARE))}
        for colour in islice(cycle(SERIES), len(names))
    ]


def _css(colour: Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)


def _describe_head(records: Sequence[Record], groups: Sequence[Group], folder: Path) -> dict[str, Any]:
    """Return the variables of the head of the page: names, numbers of runs, and terms with their texts."""
    results = [record.result for record in records]
    failing = [record.result for record in records if record.is_failure]
    judge = format_judge(results[0].judge, groups) if results else ""
    facts = [("Judge", judge), *_list_facts(results), ("Results in", str(folder))]
    return {
        "apps": _format_names(results, lambda each: each.app) or "A sweep",
        "runs": len(records),
        "failing": len(failing),
        "unverified": sum(record.result.verified is None and not record.is_failure for record in records),
        "causes": Counter(map(classify_failure, failing)).most_common(),
        "facts": [(term, text) for term, text in facts if text],
    }


def _list_facts(results: Sequence[RunResult]) -> Iterator[tuple[str, str]]:
    yield "Robot", _format_names(results, lambda each: each.robot)
    yield "Backends", _format_names(results, lambda each: each.backend)
    yield "Worlds", _format_names(results, lambda each: each.world)
    yield "Seeds", format_seeds(sorted({each.seed for each in results if each.seed is not None}))
    yield "Robot's time", _format_duration(sum(each.sim_time_s for each in results))
    yield "Computing time", _format_duration(sum(each.wall_time_s for each in results))
    yield "robotcore", read_version()
    yield "Page created", datetime.now(timezone.utc).astimezone().strftime("%Y-%m-%d %H:%M %Z")


def _format_names(results: Sequence[RunResult], name_of: Callable[[RunResult], str | None]) -> str:
    return ", ".join(dict.fromkeys(name for name in map(name_of, results) if name))


def _format_duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = [(hours, "h"), (minutes, "min"), (rest, "s")]
    return " ".join(f"{count} {unit}" for count, unit in parts if count)
