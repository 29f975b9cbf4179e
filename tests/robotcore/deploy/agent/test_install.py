from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from robotcore.deploy.agent import admin_actions, environments, push_actions
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.releases import Release
from tests.robotcore.deploy.agent.sample_releases import (
    NEW,
    NEWER,
    OLD,
    put_releases,
    read_files,
    send_release,
)
from tests.texts import Raises

CHANGES = ("os.mkdir", "os.rename", "os.symlink", "os.remove", "subprocess.Popen")

INSTALL = """
import os, signal, sys
from pathlib import Path
from robotcore.deploy.agent import push_actions
from robotcore.deploy.agent.files import Layout

home, release, last, *changes = sys.argv[1:]
left = int(last)

def die(event, given):
    global left
    if event in changes:
        left -= 1
        if left < 0:
            os.kill(os.getpid(), signal.SIGKILL)

os.sync = lambda: None  # a killed process loses nothing that is written
sys.addaudithook(die)
push_actions.install_release(Layout(Path(home)), release=release)
"""
"""A program that installs a release, and is killed before its n-th change on the disk or its n-th program."""


@pytest.fixture(autouse=True)
def _skip_sync(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sync", lambda: None)


def test_upload_becomes_a_release(layout: Layout) -> None:
    push_actions.begin_upload(layout, release=NEW, size=0)
    sent = read_files(send_release(layout, NEW))
    answer = push_actions.install_release(layout, release=NEW)
    assert answer["environment"] == "made"
    (finding,) = answer["findings"]
    assert finding["message"] == "doctor --json --robot=rover.toml --backend=raspberrypi"
    assert finding["remedy"] == str(layout.incoming / NEW / "project")
    installed = read_files(layout.releases / NEW)
    assert installed.pop("environment").startswith("../../environments/")  # type: ignore[arg-type]
    assert installed == sent
    assert (layout.releases / NEW / "environment" / "bin" / "python").exists()
    assert not any(layout.incoming.iterdir())


def test_uploaded_wheels_are_deleted_after_the_installation(layout: Layout, monkeypatch: pytest.MonkeyPatch) -> None:
    def make(layout: Layout, _recipe: object, name: str, need: environments.PipInputs) -> Path:
        assert need.wheels == layout.incoming / name / "wheels"
        assert need.wheels.joinpath("widget.whl").exists()
        return layout.environments / "made"

    monkeypatch.setattr(environments, "create_environment", make)
    monkeypatch.setattr(push_actions, "run_doctor", lambda *_: [])
    push_actions.begin_upload(layout, release=NEW, size=0)
    wheels = send_release(layout, NEW) / "wheels"
    wheels.mkdir()
    (wheels / "widget.whl").touch()
    push_actions.install_release(layout, release=NEW, is_offline=True)
    assert {path.name for path in (layout.releases / NEW).iterdir()} == {
        *("project", "site", "environment", "release.json")
    }


@pytest.mark.parametrize(
    "damage", ["rm release.json", "truncate -s 40 release.json", f"sed -i s/{NEW}/{OLD}/ release.json", "rm -r site"]
)
def test_incomplete_upload_is_refused(layout: Layout, damage: str, raises: Raises) -> None:
    push_actions.begin_upload(layout, release=NEW, size=0)
    subprocess.run(damage.split(), cwd=send_release(layout, NEW), check=True)
    with raises(AgentError, "incomplete", release=NEW):
        push_actions.install_release(layout, release=NEW)
    assert not (layout.releases / NEW).exists()


@pytest.mark.parametrize("name", ["", "../releases", f"{NEW}/..", f"{NEW}\n", "$(touch x)"])
def test_invalid_name_is_refused(layout: Layout, name: str) -> None:
    with pytest.raises(ValueError, match="is not the name of a release"):
        push_actions.install_release(layout, release=name)
    with pytest.raises(ValueError, match="is not the name of a release"):
        push_actions.begin_upload(layout, release=name, size=0)
    assert not layout.root.exists()


@pytest.mark.slow
def test_push_killed_at_any_moment_changes_no_release_and_the_next_one_works(layout: Layout) -> None:
    put_releases(layout, OLD, current=OLD)
    before = read_files(layout.releases / OLD)
    deaths = 0
    while True:
        push_actions.begin_upload(layout, release=NEW, size=0)
        send_release(layout, NEW)
        command = [sys.executable, "-c", INSTALL, str(layout.home), NEW, str(deaths), *CHANGES]
        if subprocess.run(command, stdout=subprocess.DEVNULL, check=False).returncode != -signal.SIGKILL:
            break
        deaths += 1
        assert read_files(layout.releases / OLD) == before
        answer = admin_actions.list_releases(layout)
        assert answer["current"] == OLD
        if (layout.incoming / NEW).exists():
            assert [each["name"] for each in answer["releases"]] == [OLD]
            (layout.incoming / NEW).rename(layout.incoming / OLD)  # the upload of a process that no longer runs
        else:
            _require_complete(layout.releases / NEW)
            (layout.releases / NEW).rename(layout.home / f"installed-{deaths}")
    assert deaths >= 8
    _require_complete(layout.releases / NEW)
    push_actions.begin_upload(layout, release=NEWER, size=0)
    send_release(layout, NEWER)
    assert push_actions.install_release(layout, release=NEWER)["environment"] == "kept"


def _require_complete(release: Path) -> None:
    assert Release.read(release).name == NEW
    assert (release / "environment" / "bin" / "python").exists()
