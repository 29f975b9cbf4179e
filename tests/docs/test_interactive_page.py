from __future__ import annotations

from pathlib import Path

import pytest

from robotcore import LiveRobot
from tests.docs.commands import run_command, write_files
from tests.docs.listings import ConsoleCommand, list_commands, list_listings

PAGE = (Path(__file__).parents[2] / "docs" / "interactive.md").read_text()
COMMANDS = list_commands(PAGE)


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS, ids=lambda each: each.command)
def test_script_prints_what_the_page_shows(
    command: ConsoleCommand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    write_files(list_listings(PAGE), tmp_path)
    monkeypatch.chdir(tmp_path)
    answer = run_command(command, capfd)
    assert command.matches(answer), answer


def test_page_names_every_method_of_a_live_robot() -> None:
    own = {name for name in vars(LiveRobot) if not name.startswith("_")}
    assert {name for name in own - {"is_running", "drive"} if f"robot.{name}" not in PAGE} == set()
