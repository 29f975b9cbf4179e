"""What the page tells, put together; how it looks is in ``templates``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from robotcore.description import WorldDescription, load_world, world_names
from robotcore.sweep.agreement import agreements_of
from robotcore.sweep.explain import explain, p_told
from robotcore.sweep.record import Record
from robotcore.sweep.report.colours import shades_of
from robotcore.sweep.report.conditions import condition_plot
from robotcore.sweep.report.endings import endings_of
from robotcore.sweep.report.failures import Failures
from robotcore.sweep.report.head import Head
from robotcore.sweep.report.maps import maps_of
from robotcore.sweep.report.series import Series, Spread, goal_of, milestones_of, series_of
from robotcore.sweep.report.success import success_plot
from robotcore.sweep.report.times import arrival_plot, milestone_plot
from robotcore.sweep.requirements import Requirement, missed
from robotcore.sweep.words import COLUMNS, judge_told

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
