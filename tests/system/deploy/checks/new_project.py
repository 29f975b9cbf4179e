"""A project made by one command: proven, deployed without a network, changed, taken back; its recordings fetched."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.system.deploy.desk import Desk
from tests.system.deploy.machine import make_machine
from tests.system.deploy.rover import Rover, with_text

APP = "search.py"
VIRTUAL = ("--backend", "virtualpi")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rover]:
    """A project as `robotcore new` makes it, on a target of its own: as it is but for the pins, which are simulated."""
    folder = tmp_path_factory.mktemp("new")
    with make_machine() as target:
        target.boot()
        desk = Desk.of(folder, target)
        subprocess.run(desk.command("new", "my-robot"), cwd=folder, env=desk.environment, check=True)
        rover = Rover(target, desk, folder / "my-robot")
        rover.done("push", *VIRTUAL, "--offline")
        yield rover


def test_it_is_proven_before_it_is_sent(made: Rover) -> None:
    (release,) = [each for each in json.loads(made.done("list", "--json"))["releases"] if each["name"] == made.release]
    assert [gate.partition(":")[0] for gate in release["gates"]] == ["tests", "check", "simulation"]


def test_it_runs_and_says_so(made: Rover) -> None:
    assert made.release in made.done("status")
    assert "search" in made.done("logs", "-n", "20")


def test_what_does_not_pass_its_tests_is_not_sent(made: Rover) -> None:
    app = made.project / APP
    release = made.release
    with with_text(app, app.read_text().replace("saw nothing", "found no")):
        ran = made.deploy("push", *VIRTUAL)
    assert (ran.returncode, made.release) == (1, release)
    assert "test_gives_up_where_there_is_no_ball" in ran.stderr


def test_a_changed_file_is_all_that_a_second_push_sends_and_a_rollback_takes_it_back(made: Rover) -> None:
    first, app = made.release, made.project / APP
    app.write_text(f"{app.read_text()}\n# Changed.\n")
    said = made.done("push", *VIRTUAL, "--skip-checks")
    assert "environment  kept" in said
    assert made.release > first
    made.done("rollback")
    assert made.release == first
    assert "# Changed." not in (made.files / "current" / "project" / APP).read_text()


def test_recordings_come_home_and_are_replayed(made: Rover) -> None:
    made.done("stop")
    made.done("fetch")
    recordings = sorted(made.project.rglob("*.mcap"))
    assert recordings
    command = made.desk.command("replay", str(recordings[-1]))
    refused = subprocess.run(command, cwd=made.project, env=made.desk.environment, check=False)
    assert refused.returncode == 2, "the app has changed at the desk since"
    subprocess.run([*command, "--app", APP], cwd=made.project, env=made.desk.environment, check=True)


def test_nothing_is_left_when_it_is_removed_but_the_recordings(made: Rover) -> None:
    made.done("remove", "--yes")
    assert made.desk.ssh("find robotcore .config/systemd -mindepth 1 -type f | xargs -n 1 dirname | uniq") == (
        "robotcore/recordings\n"
    )


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
