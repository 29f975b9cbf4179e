"""Print the result of a sweep: a summary and the missed requirements, or one line of JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from robotcore.cli.output import write, write_failure, write_json, write_line
from robotcore.errors import Interrupted, RobotcoreError

if TYPE_CHECKING:
    from robotcore.sweep.record import Record
    from robotcore.sweep.results import Results
    from robotcore.sweep.statistics import Group, Requirement


REQUIREMENT_MISSED = 1
"""The exit status if the results do not meet a bound of ``--require``."""

_JSON_KEYS = {"contacts_unknown": "untold"}
"""Maps the names of fields of `Group` to their keys in JSON, if both differ."""

DIGITS = 6
"""The number of decimal places of each number in JSON."""


def show_resumed(results: Results, done: int) -> None:
    """Print how many runs an earlier sweep has finished, and the date of the last one."""
    date, total = f"{results.date:%Y-%m-%d %H:%M}", len(results.sweep)
    if done == total:
        write_line(f"All runs were finished by {date}. To run them again, add --fresh.")
    else:
        write_line(f"{done} of {total} runs were finished by {date}. The sweep continues with the others.")
    write_line()


def show_sweep(
    results: Results,
    requirements: Sequence[Requirement],
    ended_by: Interrupted | RobotcoreError | None,
    *,
    as_json: bool,
    has_verify: bool,
) -> int:
    """Print the result of a sweep, and return its exit status.

    results: the results of the sweep.
    requirements: the bounds of ``--require``. They are only checked if all runs are done.
    ended_by: the error that ended the sweep, or that prevented its report; None if there was none.
    as_json: whether to print one line of JSON instead of the summary.
    has_verify: whether a judge is named or the app has a method ``verify``.
    """
    from robotcore.sweep.statistics import group_records, list_missed_requirements

    groups = group_records(results.records())
    failing = [record for record in results.records() if record.is_failure]
    done = sum(group.runs for group in groups)
    checked = requirements if done == len(results.sweep) else []
    misses = list_missed_requirements(checked, groups)
    status = ended_by.exit_status if ended_by else REQUIREMENT_MISSED if misses else 0
    if as_json:
        write_json(_build_answer(results, groups, failing, misses, ended_by, status))
    elif groups:
        _write_summary(results, groups, failing, has_verify=has_verify)
        _write_findings(results)
        if met := [str(bound) for bound in checked if all(map(bound.is_met_by, groups))]:
            write_line()
            write_line(f"Met in every group: {', '.join(met)}")
    _show_ending(results, groups, misses, ended_by)
    return status


def _build_answer(
    results: Results,
    groups: Sequence[Group],
    failing: Sequence[Record],
    misses: Sequence[str],
    ended_by: Interrupted | RobotcoreError | None,
    status: int,
) -> dict[str, Any]:
    """Return the JSON answer of ``robotcore sweep``.

    The JSON keys:

    app: text; the name of the app, or its file.
    judge: text or null; the app that verifies the runs.
    backends: list of text; the names of the backends.
    worlds: list of text; the names or files of the worlds, as given.
    seeds: text; the seeds, such as ``1-20``.
    directory: text; the folder of the results.
    runs: whole number; the number of all runs.
    done: whole number; the number of finished runs.
    failing: whole number; the number of failing runs.
    groups: list of objects; the results by backend and world.
    groups[].*: robotcore.cli.sweep_output._build_group_answer
    missed: list of text; the bounds of ``--require`` that a group does not meet.
    exit_status: whole number; the exit status.
    """
    from robotcore.sweep.spec import format_seeds

    sweep = results.sweep
    return {
        "app": sweep.request.app_reference,
        "judge": sweep.request.judge,
        "backends": sweep.backends,
        "worlds": sweep.worlds,
        "seeds": format_seeds(sweep.seeds),
        "directory": str(results.directory),
        "runs": len(sweep),
        "done": sum(group.runs for group in groups),
        "failing": len(failing),
        "groups": [_build_group_answer(group) for group in groups],
        "missed": misses,
        **_make_error_payload(ended_by),
        "exit_status": status,
    }


def _build_group_answer(group: Group) -> dict[str, Any]:
    """Return the data of a group for JSON.

    The JSON keys:

    *: robotcore.sweep.statistics.Group without contacts_unknown
    untold: whole number; the number of runs that did not count their contacts.
    verified_share: number or null; the share of verified runs, from 0 to 1. Null if no run could be verified.
    verified_95: list of two numbers, or null; the 95 % interval of ``verified_share``.
    success_share: number; the share of runs whose outcome is a success, from 0 to 1.
    """
    shares = {name: getattr(group, name) for name in ("verified_share", "verified_95", "success_share")}
    counts = {_JSON_KEYS.get(name, name): value for name, value in asdict(group).items()}
    return {key: _round(value) for key, value in {**counts, **shares}.items()}


def _round(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_round(each) for each in value]
    return round(value, DIGITS) if isinstance(value, float) else value


def _make_error_payload(ended_by: Interrupted | RobotcoreError | None) -> dict[str, str]:
    return {"error": str(ended_by), "kind": ended_by.kind} if isinstance(ended_by, RobotcoreError) else {}


def _write_summary(results: Results, groups: Sequence[Group], failing: Sequence[Record], *, has_verify: bool) -> None:
    from robotcore.sweep.summary import render_summary
    from robotcore.sweep.tables import FAILURES

    file = results.directory / FAILURES
    write(render_summary(results.sweep.request, groups, failing, file, has_verify=has_verify))
    write_line()
    write_line(f"The results: {results.directory}")


def _write_findings(results: Results) -> None:
    from robotcore.sweep.failure_analysis import explain

    lines = explain(results.records()).lines
    if lines:
        write_line()
        write_line("What failing runs have in common:")
    for line in lines:
        write_line(f"  {line}")


def _show_ending(
    results: Results,
    groups: Sequence[Group],
    misses: Sequence[str],
    ended_by: Interrupted | RobotcoreError | None,
) -> None:
    for miss in misses:
        write_failure(miss)
    if isinstance(ended_by, Interrupted):
        done = sum(group.runs for group in groups)
        text = f"{ended_by}: {done} of {len(results.sweep)} runs are saved; {results.resume_hint}."
        write_line(text, is_error=True)
    elif ended_by:
        write_failure(str(ended_by))
