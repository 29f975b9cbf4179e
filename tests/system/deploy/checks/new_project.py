"""A project of ``robotcore new`` through all commands of a deploy, and a project with difficult file names."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.system.deploy.client import Client
from tests.system.deploy.machine import make_machine
from tests.system.deploy.rover import Rover, replace_text

APP = "search.py"
VIRTUAL = ("--backend", "virtualpi")


@pytest.fixture(scope="module")
def deployed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rover]:
    """A new project on a robot of its own, with simulated pins."""
    folder = tmp_path_factory.mktemp("new")
    with make_machine() as target:
        target.boot()
        client = Client.of(folder, target)
        subprocess.run(client.command("new", "my-robot"), cwd=folder, env=client.environment, check=True)
        rover = Rover(target, client, folder / "my-robot")
        rover.run("push", *VIRTUAL, "--offline")
        yield rover


def test_checks_run_before_the_push(deployed: Rover) -> None:
    (release,) = [
        each for each in json.loads(deployed.run("list", "--json"))["releases"] if each["name"] == deployed.release
    ]
    assert [check.partition(":")[0] for check in release["checks"]] == ["tests", "check", "simulation"]


def test_status_and_logs_show_the_app(deployed: Rover) -> None:
    assert deployed.release in deployed.run("status")
    assert "search" in deployed.run("logs", "-n", "20")


def test_project_with_a_failing_test_is_not_sent(deployed: Rover) -> None:
    app = deployed.project / APP
    release = deployed.release
    with replace_text(app, app.read_text().replace("saw nothing", "found no")):
        done = deployed.deploy("push", *VIRTUAL)
    assert (done.returncode, deployed.release) == (1, release)
    assert "test_gives_up_without_a_ball" in done.stderr


def test_second_push_keeps_the_environment_and_a_rollback_restores_the_files(deployed: Rover) -> None:
    first, app = deployed.release, deployed.project / APP
    app.write_text(f"{app.read_text()}\n# Changed.\n")
    output = deployed.run("push", *VIRTUAL, "--skip-checks")
    assert "environment  kept" in output
    assert deployed.release > first
    deployed.run("rollback")
    assert deployed.release == first
    assert "# Changed." not in (deployed.files / "current" / "project" / APP).read_text()


def test_recordings_are_fetched_and_replayed(deployed: Rover) -> None:
    deployed.run("stop")
    deployed.run("fetch")
    recordings = sorted(deployed.project.rglob("*.mcap"))
    assert recordings
    command = deployed.client.command("replay", str(recordings[-1]))
    refused = subprocess.run(command, cwd=deployed.project, env=deployed.client.environment, check=False)
    assert refused.returncode == 2, "the app has changed at the client since"
    subprocess.run([*command, "--app", APP], cwd=deployed.project, env=deployed.client.environment, check=True)


def test_remove_leaves_only_the_recordings(deployed: Rover) -> None:
    deployed.run("remove", "--yes")
    assert deployed.client.ssh("find robotcore .config/systemd -mindepth 1 -type f | xargs -n 1 dirname | uniq") == (
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
def difficult(rover: Rover, tmp_path: Path) -> Rover:
    """A project whose folder and files have names with quotes and spaces."""
    folder = Path(shutil.copytree(rover.project, tmp_path / 'it\'s my "robot" $(touch pwned) ü'))
    for name in NAMES:
        file = folder / "data" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(name)
    return Rover(rover.machine, rover.client, folder)


def test_file_names_arrive_unchanged(difficult: Rover, tmp_path: Path) -> None:
    done = difficult.push("--set", "speed_rad_s=2", "--set", f"note={NOTE}")
    assert done.returncode == 0, done.stdout + done.stderr
    there = difficult.files / "releases" / difficult.release / "project" / "data"
    arrived = {str(path.relative_to(there)): path.read_text() for path in there.rglob("*") if path.is_file()}
    assert arrived == {name: name for name in NAMES}
    assert (difficult.machine.home / "noted").read_text() == NOTE
    assert not list(difficult.machine.home.rglob(CANARY))
    assert not list(tmp_path.rglob(CANARY))
