"""Put the report's page together; its layout is in ``templates``."""

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
from robotcore.sweep.failure_analysis import explain, p_told
from robotcore.sweep.record import Record, kind
from robotcore.sweep.report.charts import arrival_plot, condition_plot, milestone_plot, success_plot
from robotcore.sweep.report.drawing import shades_of
from robotcore.sweep.report.failures import Failures, endings_of
from robotcore.sweep.report.maps import maps_of
from robotcore.sweep.report.series import Series, Spread, goal_of, milestones_of, series_of
from robotcore.sweep.spec import seeds_told
from robotcore.sweep.statistics import Requirement, agreements_of, missed
from robotcore.sweep.tables import COLUMNS, judge_told

MAX_DIFFERING = 30
FEW = 8
"""So many failing runs are shown at once; more are folded, place by place."""


def page(
    records: Sequence[Record],
    folder: Path,
    asked: str,
    worlds: Sequence[WorldDescription],
    requirements: Sequence[Requirement],
) -> str:
    """Return the page as HTML; in which order the runs came to an end does not matter."""
    loader = PackageLoader("robotcore.sweep.report")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.globals |= {
        "spread": Spread.of,
        "max_differing": MAX_DIFFERING,
        "few": FEW,
        "columns": COLUMNS,
        "p_told": p_told,
    }
    records = sorted(records, key=_place)
    series = series_of(records)
    groups = [each.group for each in series]
    return environment.get_template("page.html.j2").render(
        head=Head.of(records, asked, folder, judge_told(records[0].result.judge, groups) if records else ""),
        groups=groups,
        series=series,
        success=success_plot(groups),
        requirements=requirements,
        misses=missed(requirements, groups),
        agreements=agreements_of(records),
        maps=maps_of(series, _described(series, worlds)),
        colours=shades_of(["passing", "failing", *dict.fromkeys(each.style for each in series)]),
        **_times(series),
        **_failing(records, series, folder),
    )


def _place(record: Record) -> tuple[str, str, int]:
    result = record.result
    return result.world or "", result.backend, -1 if result.seed is None else result.seed


def _times(series: Sequence[Series]) -> dict[str, Any]:
    milestones = milestones_of(series)
    goal = goal_of(series, milestones)
    return {
        "milestones": milestones,
        "goal": goal,
        "arrivals": arrival_plot(series, goal) if goal else "",
        "passages": milestone_plot(series, milestones) if goal else "",
    }


def _failing(records: Sequence[Record], series: Sequence[Series], folder: Path) -> dict[str, Any]:
    explanation = explain(records)
    return {
        "endings": endings_of(series),
        "findings": [(finding, condition_plot(finding, records)) for finding in explanation.findings],
        "silence": explanation.silence,
        "failures": Failures.of(records, folder, explanation.findings),
    }


def _described(series: Sequence[Series], worlds: Sequence[WorldDescription]) -> dict[str, WorldDescription]:
    """Return the descriptions of the worlds that are run in: those that are given, else those that are shipped."""
    shipped = set(world_names()) & {each.group.world for each in series}
    return {name: load_world(name) for name in shipped} | {world.name: world for world in worlds}


@dataclass(frozen=True)
class Head:
    """``facts`` are pairs of a term and what it is; ``causes`` how many failing runs ended in which way.

    ``said`` are those of the passing runs that nobody could verify.
    """

    apps: str
    runs: int
    failing: int
    said: int
    causes: tuple[tuple[str, int], ...]
    facts: tuple[tuple[str, str], ...]
    asked: str

    @classmethod
    def of(cls, records: Sequence[Record], asked: str, folder: Path, judge: str = "") -> Head:
        """Return the head of a page made now; the results are in ``folder``, and ``judge`` says whose word counts."""
        results = [record.result for record in records]
        failing = [record.result for record in records if record.is_failure]
        said = sum(record.result.verified is None and not record.is_failure for record in records)
        causes = tuple(Counter(map(kind, failing)).most_common())
        facts = tuple(
            (term, told)
            for term, told in [("Judge", judge), *_sweep_facts(results), ("Results in", str(folder))]
            if told
        )
        return cls(_names(results, lambda each: each.app), len(records), len(failing), said, causes, facts, asked)


def _sweep_facts(results: Sequence[RunResult]) -> Iterable[tuple[str, str]]:
    yield "Robot", _names(results, lambda each: each.robot)
    yield "Backends", _names(results, lambda each: each.backend)
    yield "Worlds", _names(results, lambda each: each.world)
    yield "Seeds", seeds_told(sorted({each.seed for each in results if each.seed is not None}))
    yield "Robot's time", _duration(sum(each.sim_time_s for each in results))
    yield "Computing time", _duration(sum(each.wall_time_s for each in results))
    yield "robotcore", version("robotcore")
    yield "Page made", datetime.now(timezone.utc).astimezone().strftime("%Y-%m-%d %H:%M %Z")


def _names(results: Sequence[RunResult], name_of: Callable[[RunResult], str | None]) -> str:
    return ", ".join(dict.fromkeys(name for name in map(name_of, results) if name))


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = [(hours, "h"), (minutes, "min"), (rest, "s")]
    return " ".join(f"{count} {unit}" for count, unit in parts if count)
