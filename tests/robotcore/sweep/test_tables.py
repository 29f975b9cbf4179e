"""Tables for a spreadsheet, and the columns of a group."""

from __future__ import annotations

import csv
import math
import os
from dataclasses import replace
from pathlib import Path

import pytest

from robotcore import Outcome
from robotcore.sweep import Record, Results
from robotcore.sweep.record import format_failure
from robotcore.sweep.single_run import RunOutput
from robotcore.sweep.statistics import Group, group_records
from robotcore.sweep.tables import COLUMNS, list_columns, write_csv
from tests.robotcore.sweep.conftest import make_record, make_sweep
from tests.texts import CheckText

SWEEP = make_sweep("green-search")
LONG_AGO_NS = 10**18

HUNG = make_record(Outcome.ERROR, verified=None, contacts=None, seed=9, time=0.0)


def _write_row(file: Path, record: Record) -> dict[str, str]:
    write_csv(file, list_columns([record]), [record])
    with file.open(newline="", encoding="utf-8") as table:
        (row,) = csv.DictReader(table)
    return row


@pytest.mark.parametrize(
    "reason, written",
    [("=HYPERLINK(A1)", "'=HYPERLINK(A1)"), ("\t@A1", "'\t@A1"), ("1 = 1", "1 = 1"), ("caf\udce9", r"caf\udce9")],
)
def test_a_text_that_looks_like_a_formula_or_is_no_unicode_is_escaped(
    tmp_path: Path, reason: str, written: str
) -> None:
    record = make_record(reason=reason)
    record = replace(record, result=replace(record.result, conditions={"light_azimuth_rad": -math.pi}))
    row = _write_row(tmp_path / "table.csv", record)
    assert row["reason"] == written
    assert float(row["conditions.light_azimuth_rad"]) == -math.pi


def test_tables_have_a_column_for_each_milestone_and_failures_a_table(tmp_path: Path) -> None:
    with Results(SWEEP, tmp_path) as results:
        passing = make_record(seed=1)
        results.add(RunOutput(replace(passing, result=replace(passing.result, milestones={"seen": 1.5}))))
        results.add(RunOutput(make_record(Outcome.TIMEOUT, seed=2)))
        results.write_tables()
    rows = _read_rows(tmp_path / "results.csv")
    assert [row["milestones.seen"] for row in rows] == ["1.5", ""]
    assert list(rows[0])[-3:] == ["fault", "command", "picture"]
    assert "path" not in rows[0]
    assert [row["seed"] for row in _read_rows(tmp_path / "failures.csv")] == ["2"]


@pytest.mark.parametrize("changed", ["results.csv", "failures.csv", "results.jsonl", ""])
def test_tables_are_written_again_if_one_is_missing_or_older_than_the_results(tmp_path: Path, changed: str) -> None:
    with Results(SWEEP, tmp_path) as results:
        results.add(RunOutput(make_record(Outcome.TIMEOUT, seed=1)))
        results.write_tables()
        os.utime(tmp_path / "results.jsonl", ns=(0, LONG_AGO_NS))
        (tmp_path / "results.csv").write_text("sorted by hand")
        if changed == "results.jsonl":
            os.utime(tmp_path / "results.csv", ns=(0, LONG_AGO_NS))
        elif changed:
            (tmp_path / changed).unlink()
        results.write_tables()
    assert ((tmp_path / "results.csv").read_text() == "sorted by hand") == (not changed)
    assert [row["seed"] for row in _read_rows(tmp_path / "failures.csv")] == ["1"]


def _read_rows(file: Path) -> list[dict[str, str]]:
    with file.open(newline="") as table:
        return list(csv.DictReader(table))


def format_columns(*names: str, group: Group) -> list[str]:
    return [COLUMNS[name](group) for name in names]


def test_a_group_has_its_share_its_interval_and_its_times() -> None:
    (group,) = group_records(
        [*(make_record(seed=seed, time=float(seed)) for seed in range(1, 20)), make_record(contacts=2)]
    )
    assert format_columns("backend", "world", "passed", group=group) == ["kinematic", "open", "19/20"]
    assert format_columns("verified", "%", "95 %", "contacts", group=group) == ["20/20", "100.0", "83.9–100.0", "2"]
    assert format_columns("median", "90 % within", "slowest", group=group) == ["10.5 s", "18.0 s", "never"]


def test_a_group_without_a_judge_has_a_question_mark_and_no_share() -> None:
    (group,) = group_records([make_record(verified=None, contacts=None)] * 3)
    assert format_columns("passed", "verified", "%", "95 %", "contacts", group=group) == ["3/3", "?/3", "", "", "?"]


@pytest.mark.parametrize(
    "record",
    [
        make_record(Outcome.ERROR, reason="the wheel fell off"),
        make_record(verified=False),
        make_record(verified=False, reason="there"),
        make_record(verified=False, judge="green-search"),
        make_record(contacts=1),
        make_record(Outcome.TIMEOUT, reason="late", contacts=2),
    ],
    ids=["error", "dispute", "dispute with reason", "dispute of judge", "contact", "contacts"],
)
def test_a_failure_has_outcome_reason_and_contacts(record: Record, check_text: CheckText) -> None:
    check_text(format_failure(record))
