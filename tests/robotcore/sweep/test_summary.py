from __future__ import annotations

from pathlib import Path

from rich.console import Console

from robotcore import Outcome, RunRequest
from robotcore.sweep import Record
from robotcore.sweep.statistics import group_records
from robotcore.sweep.summary import render_summary
from tests.robotcore.sweep.conftest import record_of

GREEN_SEARCH = RunRequest("green-search")


def _lines(records: list[Record], width: int = 80, request: RunRequest = GREEN_SEARCH) -> list[str]:
    console = Console(width=width, highlight=False, markup=False)
    failing = [record for record in records if record.is_failure]
    with console.capture() as capture:
        console.print(render_summary(request, group_records(records), failing, Path("failures.csv")))
    return capture.get().splitlines()


def test_a_row_has_share_interval_contacts_and_times() -> None:
    records = [record_of(seed=seed, world="clutter", time=12.25) for seed in range(200)]
    assert _lines(records)[2].split() == (
        ["kinematic", "clutter", "200/200", "100.0", "98.1–100.0", "0", "12.2", "s", "12.2", "s"]
    )


def test_a_run_that_hung_leaves_contacts_open_and_the_slowest_never_there() -> None:
    hung = record_of(Outcome.ERROR, verified=None, contacts=None, seed=199, time=0.0)
    lines = _lines([*(record_of(seed=seed, time=12.25) for seed in range(199)), hung])
    assert lines[2].split() == ["kinematic", "open", "199/200", "99.5", "97.2–99.9", "≥", "0", "12.2", "s", "never"]


def test_the_table_fits_into_80_letters() -> None:
    header, rule, row, *_ = _lines([record_of(world="occluded", time=100.0) for _ in range(1000)])
    assert "…" not in header + row
    assert len(rule) <= 80
    assert len(_lines([record_of()])) == 3


def test_one_failing_run_is_named_by_its_cause_and_its_command() -> None:
    lines = _lines([record_of(Outcome.TIMEOUT, seed=9, reason="late"), record_of()])
    assert lines[4:] == ["1 failing run:", "  timeout, late", "    robotcore run green-search --world open --seed 9"]


def test_failing_runs_of_one_cause_are_reported_together_the_commonest_first() -> None:
    late = [record_of(Outcome.TIMEOUT, seed=seed, reason="late") for seed in (10, 9)]
    late += [record_of(Outcome.TIMEOUT, seed=seed, reason="late", world="clutter") for seed in range(9)]
    lines = _lines([record_of(Outcome.FAILURE, world="arena", reason="stuck"), *late])
    assert lines[6:] == [
        "12 failing runs:",
        "  11 × timeout, late",
        "    in clutter on kinematic: seeds 0, 1, 2, 3, 4, 5, 6, 7 and 1 more",
        "    in open on kinematic: seeds 9, 10",
        "    robotcore run green-search --world clutter --seed 0",
        "  failure, stuck",
        "    robotcore run green-search --world arena --seed 1",
        "  each of them: failures.csv",
    ]


def test_many_causes_are_left_to_the_file() -> None:
    lines = _lines([record_of(Outcome.ERROR, seed=seed, reason=f"reason {seed}") for seed in range(23)])
    assert sum("robotcore run" in line for line in lines) == 20
    assert lines[-2:] == ["  and 3 more causes", "  each of them: failures.csv"]


def test_whose_word_it_is_is_reported_of_an_app_in_a_file_and_where_a_judge_was_named() -> None:
    assert not any("Judge" in line for line in _lines([record_of()]))
    assert "Judge: the app itself" in _lines([record_of()], request=RunRequest("kim.py"))
    assert "Judge: nobody" in _lines([record_of(verified=None)], request=RunRequest("kim.py"))
    assert "Judge: strict.py" in _lines([record_of()], request=RunRequest("green-search", judge="strict.py"))


def test_a_judge_that_was_named_is_who_does_not_agree() -> None:
    lines = _lines([record_of(verified=False, judge="green-search")])
    assert "  success, the judge does not agree" in lines
