from __future__ import annotations

from pathlib import Path

import pytest
from rich.console import Console

from robotcore import Outcome, RunRequest
from robotcore.sweep import Record
from robotcore.sweep.statistics import group_records
from robotcore.sweep.summary import render_summary
from tests.robotcore.sweep.conftest import make_record
from tests.texts import CheckText

GREEN_SEARCH = RunRequest("green-search")
NO_VERIFY_APP = RunRequest("avoid-obstacles")


def _render_lines(records: list[Record], width: int = 80, request: RunRequest = GREEN_SEARCH) -> list[str]:
    has_verify = request.app != NO_VERIFY_APP.app
    console = Console(width=width, highlight=False, markup=False)
    failing = [record for record in records if record.is_failure]
    with console.capture() as capture:
        summary = render_summary(request, group_records(records), failing, Path("failures.csv"), has_verify=has_verify)
        console.print(summary)
    return capture.get().splitlines()


def test_failing_runs_are_grouped_by_cause_the_most_frequent_first(check_text: CheckText) -> None:
    late = [make_record(Outcome.TIMEOUT, seed=seed, reason="late") for seed in (10, 9)]
    late += [make_record(Outcome.TIMEOUT, seed=seed, reason="late", world="clutter") for seed in range(9)]
    lines = _render_lines([make_record(Outcome.FAILURE, world="arena", reason="stuck"), *late])
    check_text("\n".join(lines[6:]))


def test_measured_values_do_not_distinguish_causes() -> None:
    reasons = ["the wheel turned 7.8 rad in 1.6 s, or 3°", "the wheel turned -0.1 rad in 2.0 s, or 40°"]
    records = [
        make_record(Outcome.STOPPED, seed=seed, reason=each, contacts=seed + 1) for seed, each in enumerate(reasons)
    ]
    assert f"  2 × stopped, {reasons[0]}, 1 contact" in _render_lines(records)


def test_only_the_most_frequent_causes_are_listed(check_text: CheckText) -> None:
    lines = _render_lines([make_record(Outcome.ERROR, seed=seed, reason=f"reason {seed}") for seed in range(23)])
    assert sum("robotcore run" in line for line in lines) == 20
    assert all(len(line) <= 80 for line in lines[:3])
    check_text("\n".join(lines[-2:]))


@pytest.mark.parametrize(
    "request_, verified",
    [
        (GREEN_SEARCH, True),
        (RunRequest("kim.py"), True),
        (RunRequest("kim.py"), None),
        (RunRequest("green-search", judge="strict.py"), True),
        (NO_VERIFY_APP, None),
    ],
    ids=["installed app", "app in a file", "no judge", "judge", "no verify"],
)
def test_the_judge_is_named_unless_it_is_an_installed_app(
    request_: RunRequest, verified: bool | None, check_text: CheckText
) -> None:
    check_text("\n".join(_render_lines([make_record(verified=verified)], request=request_)[3:]))
