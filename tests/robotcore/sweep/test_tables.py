from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import pytest

from robotcore.sweep import Record
from robotcore.sweep.tables import columns_of, write_csv
from tests.robotcore.sweep.conftest import record_of


def _row(file: Path, record: Record) -> dict[str, str]:
    write_csv(file, columns_of([record]), [record])
    with file.open(newline="", encoding="utf-8") as table:
        (row,) = csv.DictReader(table)
    return row


@pytest.mark.parametrize("start", ["=", "+", "-", "@", "\t", "\r"])
def test_what_a_spreadsheet_takes_for_a_formula_is_text(tmp_path: Path, start: str) -> None:
    reason = f"{start}HYPERLINK(A1)"
    assert _row(tmp_path / "table.csv", record_of(reason=reason))["reason"] == f"'{reason}"


def test_words_and_negative_numbers_stay_as_they_are(tmp_path: Path) -> None:
    record = record_of(reason="1 = 1")
    record = replace(record, result=replace(record.result, conditions={"light_azimuth_rad": -math.pi, "floor": "wood"}))
    row = _row(tmp_path / "table.csv", record)
    assert (row["reason"], row["conditions.floor"]) == ("1 = 1", "wood")
    assert float(row["conditions.light_azimuth_rad"]) == -math.pi


def test_a_reason_that_is_no_unicode_is_told_with_its_bytes(tmp_path: Path) -> None:
    assert _row(tmp_path / "table.csv", record_of(reason="no caf\udce9 here"))["reason"] == r"no caf\udce9 here"
