from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from robotcore import LiveRobot
from tests.docs.listings import ConsoleCommand, list_commands, list_listings

PAGE = (Path(__file__).parents[2] / "docs" / "interactive.md").read_text()
LISTINGS = list_listings(PAGE)
COMMANDS = [
    each
    for listing in LISTINGS
    if listing.language == "console"
    for each in list_commands(listing.text)
    if each.command.startswith("python")
]


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS, ids=lambda each: each.command)
def test_script_prints_what_the_page_shows(command: ConsoleCommand, tmp_path: Path) -> None:
    for listing in LISTINGS:
        if listing.language == "python":
            (tmp_path / listing.file).write_text(listing.text)
    words = [sys.executable, *command.command.split()[1:]]
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert command.matches(ended.stdout), ended.stdout


def test_page_names_every_method_of_a_live_robot() -> None:
    own = {name for name in vars(LiveRobot) if not name.startswith("_")}
    assert {name for name in own - {"is_running", "drive"} if f"robot.{name}" not in PAGE} == set()
