"""A project made by one command: proven, deployed without a network, changed, taken back; its recordings fetched."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator

import pytest

from tests.system.deploy.desk import Desk
from tests.system.deploy.machine import machine
from tests.system.deploy.projects import rewritten
from tests.system.deploy.rover import Rover

APP = "search.py"
VIRTUAL = ("--backend", "virtualpi")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rover]:
    """A project as `robotcore new` makes it, on a target of its own: as it is but for the pins, which are simulated."""
    folder = tmp_path_factory.mktemp("new")
    with machine() as target:
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
    with rewritten(app, app.read_text().replace("saw nothing", "found no")):
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
