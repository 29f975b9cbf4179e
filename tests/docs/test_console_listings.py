"""The commands in the console listings of a page print what the page shows."""

from __future__ import annotations

import io
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from robotcore.cli.main import execute
from tests.docs.listings import ConsoleCommand, list_commands, list_listings, write_files

PAGES = {
    name: (Path(__file__).parents[2] / "docs" / f"{name}.md").read_text()
    for name in ("apps", "interactive", "manoeuvres", "navigation", "raspberry-pi", "run-from-python")
}
COMMANDS = [
    pytest.param(page, command, id=f"{name}-{command.command}")
    for name, page in PAGES.items()
    for command in list_commands(page)
]


@pytest.mark.slow
@pytest.mark.parametrize("page, command", COMMANDS)
def test_command_output_equals_the_page(
    page: str,
    command: ConsoleCommand,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    write_files(list_listings(page), tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO())
    program, *arguments = shlex.split(command.command)
    if program == "robotcore":
        execute(arguments)
    else:
        module = [] if program == "python" else ["-m", program]
        subprocess.run([sys.executable, *module, *arguments], check=False)
    answer = "".join(capfd.readouterr())
    assert command.matches(answer), answer
