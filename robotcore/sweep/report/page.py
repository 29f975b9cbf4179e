"""The HTML page of the report. Its layout is in ``templates``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from robotcore.description import WorldDescription, load_world, world_names
from robotcore.runtime.result import RunResult
from robotcore.sweep.failure_analysis import explain, format_p
from robotcore.sweep.record import Record, classify_failure
from robotcore.sweep.report.charts import plot_arrivals, plot_condition, plot_milestones, plot_success
from robotcore.sweep.report.drawing import compute_shades
from robotcore.sweep.report.failures import Failures, count_endings
from robotcore.sweep.report.maps import draw_maps
from robotcore.sweep.report.series import Series, Spread, find_goal, list_milestones, make_series
from robotcore.sweep.spec import format_seeds
from robotcore.sweep.statistics import Requirement, compare_backends, list_missed_requirements
from robotcore.sweep.tables import COLUMNS, format_judge

MAX_DIFFERING = 30
"""The maximum number of differing runs in the table of two backends."""

MAX_OPEN = 8
"""The maximum number of failing runs whose groups are unfolded when the page opens."""


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
    environment.globals |= {
        "spread": Spread.of,
        "max_differing": MAX_DIFFERING,
        "few": MAX_OPEN,
        "columns": COLUMNS,
        "format_p": format_p,
    }
    records = sorted(records, key=_sort_key)
    series = make_series(records)
    groups = [each.group for each in series]
    return environment.get_template("page.html.j2").render(
        head=Head.of(records, command, folder, format_judge(records[0].result.judge, groups) if records else ""),
        groups=groups,
        series=series,
        success=plot_success(groups),
        requirements=requirements,
        misses=list_missed_requirements(requirements, groups),
        agreements=compare_backends(records),
        maps=draw_maps(series, _load_worlds(series, worlds)),
        colours=compute_shades(["passing", "failing", *dict.fromkeys(each.style for each in series)]),
        **_render_times(series),
        **_render_failing(records, series, folder),
    )


def _sort_key(record: Record) -> tuple[str, str, int]:
    result = record.result
    return result.world or "", result.backend, -1 if result.seed is None else result.seed


def _render_times(series: Sequence[Series]) -> dict[str, Any]:
    milestones = list_milestones(series)
    goal = find_goal(series, milestones)
    return {
        "milestones": milestones,
        "goal": goal,
        "arrivals": plot_arrivals(series, goal) if goal else "",
        "passages": plot_milestones(series, milestones) if goal else "",
    }


def _render_failing(records: Sequence[Record], series: Sequence[Series], folder: Path) -> dict[str, Any]:
    explanation = explain(records)
    return {
        "endings": count_endings(series),
        "splits": [(each, plot_condition(each, records)) for each in explanation.splits],
        "no_split": explanation.reason,
        "failures": Failures.of(records, folder, explanation.splits),
    }


def _load_worlds(series: Sequence[Series], worlds: Sequence[WorldDescription]) -> dict[str, WorldDescription]:
    shipped = set(world_names()) & {each.group.world for each in series}
    return {name: load_world(name) for name in shipped} | {world.name: world for world in worlds}


@dataclass(frozen=True)
class Head:
    """The head of the page: the apps, the command, the facts, and the numbers of failing runs."""

    apps: str
    """The names of the apps, separated by commas."""

    runs: int
    """The number of runs."""

    failing: int
    """The number of failing runs."""

    unverified: int
    """The number of passing runs that could not be verified."""

    causes: tuple[tuple[str, int], ...]
    """The classes of failing runs, as `classify_failure` returns them, and the number of runs in each class."""

    facts: tuple[tuple[str, str], ...]
    """Terms with their texts, such as ``Robot`` with the name of the robot."""

    command: str
    """The command line of the sweep."""

    @classmethod
    def of(cls, records: Sequence[Record], command: str, folder: Path, judge: str = "") -> Head:
        """Return the head of a page.

        records: the records of the sweep.
        command: the command line of the sweep.
        folder: the folder of the results.
        judge: who judged the runs, as `format_judge` returns it.
        """
        results = [record.result for record in records]
        failing = [record.result for record in records if record.is_failure]
        unverified = sum(record.result.verified is None and not record.is_failure for record in records)
        causes = tuple(Counter(map(classify_failure, failing)).most_common())
        facts = tuple(
            (term, text)
            for term, text in [("Judge", judge), *_list_facts(results), ("Results in", str(folder))]
            if text
        )
        return cls(
            _format_names(results, lambda each: each.app),
            len(records),
            len(failing),
            unverified,
            causes,
            facts,
            command,
        )


def _list_facts(results: Sequence[RunResult]) -> Iterable[tuple[str, str]]:
    yield "Robot", _format_names(results, lambda each: each.robot)
    yield "Backends", _format_names(results, lambda each: each.backend)
    yield "Worlds", _format_names(results, lambda each: each.world)
    yield "Seeds", format_seeds(sorted({each.seed for each in results if each.seed is not None}))
    yield "Robot's time", _format_duration(sum(each.sim_time_s for each in results))
    yield "Computing time", _format_duration(sum(each.wall_time_s for each in results))
    yield "robotcore", version("robotcore")
    yield "Page created", datetime.now(timezone.utc).astimezone().strftime("%Y-%m-%d %H:%M %Z")


def _format_names(results: Sequence[RunResult], name_of: Callable[[RunResult], str | None]) -> str:
    return ", ".join(dict.fromkeys(name for name in map(name_of, results) if name))


def _format_duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = [(hours, "h"), (minutes, "min"), (rest, "s")]
    return " ".join(f"{count} {unit}" for count, unit in parts if count)
