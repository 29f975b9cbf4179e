"""Whatever a user's files are called, they arrive as they are, and no shell reads their names."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.system.deploy.rover import Rover

NAMES = (
    "with a space.txt",
    'it\'s "quoted".txt',
    "ünïcødé 🤖.txt",
    "new\nline.txt",
    "$(touch pwned) `touch pwned`; touch pwned.txt",
    "-rf",
    "*",
    "back\\slash",
    "a folder/with 'another'/and a file",
    "::colons:and@ats",
)
CANARY = "pwned"
NOTE = "$(touch pwned)'; touch pwned; \" ü\nand on"


@pytest.fixture
def odd(rover: Rover, tmp_path: Path) -> Rover:
    """The project in a folder with a name as odd as its files'."""
    folder = Path(shutil.copytree(rover.project, tmp_path / 'it\'s my "robot" $(touch pwned) ü'))
    for name in NAMES:
        file = folder / "data" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(name)
    return Rover(rover.machine, rover.desk, folder)


def test_files_arrive_as_they_are_called(odd: Rover, tmp_path: Path) -> None:
    ran = odd.push("--set", "speed_rad_s=2", "--set", f"note={NOTE}")
    assert ran.returncode == 0, ran.stdout + ran.stderr
    there = odd.files / "releases" / odd.release / "project" / "data"
    arrived = {str(path.relative_to(there)): path.read_text() for path in there.rglob("*") if path.is_file()}
    assert arrived == {name: name for name in NAMES}
    assert (odd.machine.home / "noted").read_text() == NOTE
    assert not list(odd.machine.home.rglob(CANARY))
    assert not list(tmp_path.rglob(CANARY))
