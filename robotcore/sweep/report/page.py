"""What the page tells, put together; how it looks is in ``templates``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from robotcore.description import WorldDescription, load_world, world_names
from robotcore.sweep.agreement import agreements_of
from robotcore.sweep.explain import explain
from robotcore.sweep.record import Record
from robotcore.sweep.report.colours import shades_of
from robotcore.sweep.report.conditions import condition_plot
from robotcore.sweep.report.failures import Failure
from robotcore.sweep.report.head import Head
from robotcore.sweep.report.maps import maps_of
from robotcore.sweep.report.series import Series, Spread, goal_of, milestones_of, series_of
from robotcore.sweep.report.success import success_plot
from robotcore.sweep.report.times import arrival_plot, milestone_plot
from robotcore.sweep.summary import contacts_told, time_told
from robotcore.sweep.thinning import thinned

MAX_PICTURES = 40
"""Such a page still goes through the mail: about 16 MB."""

MAX_DIFFERING = 30


def page(records: Sequence[Record], pictures: Path, asked: str, worlds: Sequence[WorldDescription]) -> str:
    """Return the page as HTML; in which order the runs came to an end does not matter."""
    loader = PackageLoader("robotcore.sweep.report")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.globals |= {
        "spread": Spread.of,
        "max_differing": MAX_DIFFERING,
        "contacts": contacts_told,
        "time": time_told,
    }
    return environment.get_template("page.html.j2").render(
        _contents(sorted(records, key=_place), pictures, asked, worlds)
    )


def _place(record: Record) -> tuple[str, str, int]:
    result = record.result
    return result.world or "", result.backend, -1 if result.seed is None else result.seed


def _contents(
    records: Sequence[Record], pictures: Path, asked: str, worlds: Sequence[WorldDescription]
) -> dict[str, Any]:
    series = series_of(records)
    groups = [each.group for each in series]
    milestones = milestones_of(series)
    goal = goal_of(series, milestones)
    return {
        "head": Head.of(records, asked),
        "groups": groups,
        "series": series,
        "milestones": milestones,
        "goal": goal,
        "success": success_plot(groups),
        "arrivals": arrival_plot(series, goal) if goal else "",
        "passages": milestone_plot(series, milestones) if goal else "",
        "maps": maps_of(series, _described(series, worlds)),
        "agreements": agreements_of(records),
        "findings": [(finding, condition_plot(finding, records)) for finding in explain(records)],
        **_failures(records, pictures),
        "colours": shades_of(["passing", "failing", *dict.fromkeys(each.style for each in series)]),
    }


def _failures(records: Sequence[Record], pictures: Path) -> dict[str, list[Failure]]:
    failing = [record for record in records if record.is_failure]
    chosen = set(thinned(range(len(failing)), MAX_PICTURES))
    return {
        "pictured": [Failure.of(failing[index], pictures) for index in sorted(chosen)],
        "listed": [Failure.of(record) for index, record in enumerate(failing) if index not in chosen],
    }


def _described(series: Sequence[Series], worlds: Sequence[WorldDescription]) -> dict[str, WorldDescription]:
    """Return the descriptions of the worlds that are run in: those that are given, else those that are shipped."""
    shipped = set(world_names()) & {each.group.world for each in series}
    return {name: load_world(name) for name in shipped} | {world.name: world for world in worlds}
