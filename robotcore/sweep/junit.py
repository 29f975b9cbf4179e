"""The results of a sweep as JUnit test suites: a suite for each backend in each world, a case for each run."""

from __future__ import annotations

from collections.abc import Sequence

from robotcore.compatibility import read_version
from robotcore.junit import JUnitCase, JUnitSuite, Problem, ProblemElement
from robotcore.runtime.apps import app_path
from robotcore.runtime.result import Outcome
from robotcore.sweep.record import GroupKey, Record, classify_failure, format_failure
from robotcore.sweep.results import Results
from robotcore.sweep.statistics import Group, Requirement, format_miss, group_records
from robotcore.text import pluralize

GATE = "gate"
"""The kind of a requirement that a group misses."""


def build_suites(results: Results, requirements: Sequence[Requirement], command: str) -> list[JUnitSuite]:
    """Return a suite for each backend in each world. It has a case for each run, then one for each requirement.

    results: the results of the sweep.
    requirements: the requirements that each group must meet.
    command: the command line of the sweep, which repeats it.

    A failing run is a failure, or an error if its outcome is ``error``. If there are requirements and its group meets
    all of them, the run is skipped, because the sweep allows it. So a file without failures and errors means that the
    requirements are met.
    """
    groups = {GroupKey(group.backend, group.world): group for group in group_records(results.records())}
    runs: dict[GroupKey, list[Record]] = {key: [] for key in groups}
    for record in results.records():
        runs[GroupKey.from_record(record)].append(record)
    return [_build_suite(results, group, runs[key], requirements, command) for key, group in groups.items()]


def _build_suite(
    results: Results, group: Group, records: Sequence[Record], requirements: Sequence[Requirement], command: str
) -> JUnitSuite:
    first, key = records[0].result, GroupKey(group.backend, group.world)
    is_allowed = bool(requirements) and all(each.is_met_by(group) for each in requirements)
    name = ".".join(part for part in (app_path(first.app).stem, group.backend, group.world) if part)
    facts = {
        "app": first.app,
        "judge": first.judge or "",
        "robot": first.robot,
        "backend": group.backend,
        "world": group.world,
        "command": command,
        "results": str(results.directory),
        "robotcore": read_version(),
    }
    ordered = sorted(records, key=lambda record: -1 if record.result.seed is None else record.result.seed)
    return JUnitSuite(
        f"{first.app} {key}",
        [
            *(_build_run_case(results, record, name, key, is_allowed=is_allowed) for record in ordered),
            *(_build_gate_case(each, group, name, key, command) for each in dict.fromkeys(requirements)),
        ],
        {fact: value for fact, value in facts.items() if value},
        results.date,
    )


def _build_run_case(results: Results, record: Record, name: str, key: GroupKey, *, is_allowed: bool) -> JUnitCase:
    result = record.result
    contacts = "contacts unknown" if result.contacts is None else pluralize(result.contacts, "contact")
    measures = f"{result.headline}, {result.sim_time_s:.1f} s on the robot's clock, {contacts}"
    picture = f"\n[[ATTACHMENT|{results.directory / record.picture}]]" if record.picture else ""
    return JUnitCase(
        name,
        f"seed {result.seed} {key}",
        result.wall_time_s,
        _find_problem(record, measures, is_allowed=is_allowed),
        f"{measures}\n{record.command}{picture}",
    )


def _find_problem(record: Record, measures: str, *, is_allowed: bool) -> Problem | None:
    if not record.is_failure:
        return None
    result, cause = record.result, format_failure(record)
    verdict = ProblemElement.ERROR if result.outcome is Outcome.ERROR else ProblemElement.FAILURE
    details = f"{cause}\n\nSeed {result.seed}: {measures}\nRepeat the run: {record.command}"
    if is_allowed:
        return Problem(
            ProblemElement.SKIPPED, classify_failure(result), f"allowed by the requirements: {cause}", details
        )
    return Problem(verdict, classify_failure(result), cause, details)


def _build_gate_case(requirement: Requirement, group: Group, name: str, key: GroupKey, command: str) -> JUnitCase:
    problem, output = None, f"{requirement.measure} is {requirement.format_value(group)}, required {requirement}"
    if not requirement.is_met_by(group):
        miss = format_miss(requirement, group)
        problem = Problem(ProblemElement.FAILURE, GATE, miss, f"{miss}\n\nRepeat the sweep: {command}")
    return JUnitCase(name, f"{requirement} {key}", problem=problem, output=output)
