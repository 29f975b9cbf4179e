from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from robotcore.cli.main import execute
from tests.docs.listings import CODE, list_commands, list_listings, read_rows
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


@pytest.mark.slow
def test_the_commands_of_the_page_print_what_it_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """The first command makes the recording that the others read."""
    monkeypatch.chdir(tmp_path)
    commands = list_commands(PAGE)
    assert len(commands) > 3
    for each in commands:
        execute(shlex.split(each.command)[1:])
        answer = "".join(capfd.readouterr())
        assert each.matches(answer), answer
    header = Path("run.csv").read_text().partition("\n")[0].split(",")
    named = {"time_s", "asked_left_rad_s", "sent_left_rad_s", "x_m", "true_x_m", "nose_m", "nose_time_s"}
    assert named <= set(header)
    assert [name for name in named if f"`{name}`" not in PAGE] == []


def test_the_table_names_every_channel_and_its_schema() -> None:
    answer = [
        (CODE.findall(channels), CODE.findall(schema))
        for channels, schema, _ in read_rows(PAGE, "View a recording in Foxglove")
    ]
    assert {channel for channels, _ in answer for channel in channels} == set(SCHEMAS)
    for channels, schemas in answer:
        named = [schema for schema in schemas if "." in schema]
        assert not named or {SCHEMAS[channel] for channel in channels} <= set(named)
