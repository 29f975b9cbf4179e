from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.docs.listings import CODE, list_listings, read_rows
from tests.robotcore.recording.test_foxglove_channels import SCHEMAS

PAGE = (Path(__file__).parents[2] / "docs" / "recording.md").read_text()


def test_the_listing_records_a_run_and_reads_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (listing,) = (each.text for each in list_listings(PAGE) if each.language == "python")
    exec(compile(listing, "recording.md", "exec"), {})  # noqa: S102  the page's own
    answer = capsys.readouterr().out.splitlines()
    assert answer[0].startswith("2.0 ")
    assert any(re.fullmatch(r"nose Range (\d\.\d\d m|nothing in range) at 2.00 s", line) for line in answer[1:])


def test_the_table_names_every_channel_and_its_schema() -> None:
    answer = [
        (CODE.findall(channels), CODE.findall(schema))
        for channels, schema, _ in read_rows(PAGE, "View a recording in Foxglove")
    ]
    assert {channel for channels, _ in answer for channel in channels} == set(SCHEMAS)
    for channels, schemas in answer:
        named = [schema for schema in schemas if "." in schema]
        assert not named or {SCHEMAS[channel] for channel in channels} <= set(named)
