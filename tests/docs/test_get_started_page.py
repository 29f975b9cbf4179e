"""The commands of the page "Get started" run in their order, and print what the page shows."""

from __future__ import annotations

import io
import shlex
from pathlib import Path

import pytest

from robotcore.cli.main import execute
from tests.docs.listings import list_commands, list_listings

PAGE = (Path(__file__).parents[2] / "docs" / "index.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_commands_make_a_project_and_print_what_the_page_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO())
    for command in list_commands(PAGE):
        program, *arguments = shlex.split(command.command)
        if program == "cd":
            monkeypatch.chdir(arguments[0])
            continue
        assert execute(arguments) == 0
        answer = "".join(capfd.readouterr())
        assert command.matches(answer), answer
    sweep = next(listing.text for listing in list_listings(PAGE) if "robotcore sweep" in listing.text)
    assert execute(shlex.split(sweep)[1:]) == 0
