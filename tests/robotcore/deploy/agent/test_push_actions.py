from __future__ import annotations

import json
import platform
import sys
from pathlib import Path
from typing import Any

import pytest

from robotcore.deploy.agent import environments, files, push_actions, releases, robot_facts
from robotcore.deploy.agent.environments import EnvironmentSpec
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.releases import ENVIRONMENT, HEALTHY, UNHEALTHY, HealthResult, Release
from robotcore.deploy.robot_answers import ProbeAnswer
from tests.robotcore.deploy.agent.sample_releases import (
    NEW,
    NEWER,
    OLD,
    make_current,
    put_release,
    read_files,
    send_release,
)
from tests.texts import CheckText


@pytest.mark.usefixtures("lingering", "systemd")
def test_probe_returns_the_facts_and_whether_the_environment_exists(layout: Layout) -> None:
    answer = push_actions.probe(layout, requirements=[])
    assert ProbeAnswer(**answer).machine == platform.machine()
    assert answer["free_bytes"] > 0
    assert not answer["has_environment"]
    assert not layout.root.exists()
    environments.create_environment(layout, EnvironmentSpec.from_requirements([]), OLD, environments.PipInputs())
    assert push_actions.probe(layout, requirements=[])["has_environment"]
    assert not push_actions.probe(layout, requirements=["numpy"])["has_environment"]


@pytest.fixture
def unprepared_robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A robot that meets no requirement of a push, and whose user has no permission to change that."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(robot_facts, "LINGER_FOLDER", tmp_path)
    monkeypatch.setattr(robot_facts, "count_bits", lambda: 32)
    monkeypatch.setattr(robot_facts, "has_venv", lambda: False)
    monkeypatch.setattr(robot_facts, "read_user", lambda: "pi")


@pytest.mark.usefixtures("unprepared_robot")
def test_push_is_refused_with_every_missing_need(layout: Layout, check_text: CheckText) -> None:
    with pytest.raises(AgentError) as refused:
        push_actions.probe(layout, requirements=[])
    assert refused.value.fields["kinds"] == ("architecture", "rsync", "venv", "no-systemd")
    assert refused.value.kind == "architecture"
    check_text(refused.value, hide=[robot_facts.read_system()])


@pytest.mark.usefixtures("unprepared_robot")
def test_lingering_is_turned_on_if_the_user_may_do_that(tmp_path: Path) -> None:
    loginctl = tmp_path / "loginctl"
    loginctl.write_text(f'#!/bin/sh\necho "$@" > "{tmp_path}/arguments"; : > "{tmp_path}/pi"\n')
    loginctl.chmod(0o755)
    assert robot_facts.enable_lingering()
    assert (tmp_path / "arguments").read_text() == "--no-ask-password enable-linger\n"


def test_next_push_copies_from_the_current_release(layout: Layout) -> None:
    answer = push_actions.begin_upload(layout, release=NEWER, size=1000)
    assert answer == {"release": NEWER, "to": f"incoming/{NEWER}", "copy_from": None}
    push_actions.discard_upload(layout, release=NEWER)
    for name in (OLD, NEW):
        put_release(layout, name)
    assert push_actions.begin_upload(layout, release=NEWER, size=1000)["copy_from"] == f"releases/{NEW}"
    make_current(layout, OLD)
    assert push_actions.begin_upload(layout, release=NEWER, size=1000)["copy_from"] == f"releases/{OLD}"


def test_simultaneous_pushes_have_different_names_and_folders(layout: Layout) -> None:
    answer = [push_actions.begin_upload(layout, release=OLD, size=1000) for _ in range(3)]
    assert [each["release"] for each in answer] == [OLD, NEW, NEWER]
    assert [each["to"] for each in answer] == [f"incoming/{name}" for name in (OLD, NEW, NEWER)]
    put_release(layout, "2027-12-31T23-59-59Z")  # a client with a slow clock
    assert push_actions.begin_upload(layout, release=OLD, size=1000)["release"] == "2028-01-01T00-00-00Z"


def test_too_large_upload_is_refused_and_deleted(layout: Layout, check_text: CheckText) -> None:
    before = read_files(put_release(layout, OLD))
    make_current(layout, OLD)
    for size in (0, 2_000_000):
        layout.recordings.mkdir(exist_ok=True)
        (layout.recordings / "long.mcap").write_bytes(bytes(size))
        with pytest.raises(AgentError) as refused:
            push_actions.begin_upload(layout, release=NEW, size=10**15)
        assert (refused.value.kind, refused.value.fields["size"]) == ("disk", 10**15)
        check_text(refused.value.remedy)
    assert read_files(layout.releases / OLD) == before
    assert not any(layout.incoming.glob(NEW))


def test_upload_can_be_discarded(layout: Layout) -> None:
    push_actions.begin_upload(layout, release=NEW, size=1000)
    send_release(layout, NEW)
    assert push_actions.discard_upload(layout, release=NEW) == {"discarded": True}
    assert push_actions.discard_upload(layout, release=NEW) == {"discarded": False}
    assert not any(layout.incoming.iterdir())


NAMES = [f"2026-11-{day:02}T00-00-00Z" for day in range(1, 10)]


@pytest.fixture
def full_robot(layout: Layout) -> Layout:
    """A robot with nine releases: the first two are healthy, the second runs, and all later ones failed."""
    for number, name in enumerate(NAMES):
        HealthResult(HEALTHY if number < 2 else UNHEALTHY).write(put_release(layout, name))
    make_current(layout, NAMES[1])
    return layout


def test_old_releases_are_deleted_if_the_disk_is_nearly_full(
    full_robot: Layout, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "measure_free_space", lambda _: push_actions.SPARE_BYTES)
    with pytest.raises(AgentError):
        push_actions.begin_upload(full_robot, release="2026-12-01T00-00-00Z", size=1000)
    assert releases.list_names(full_robot) == [NAMES[8], NAMES[1], NAMES[0]]
    kept = {path.name for path in full_robot.environments.iterdir()}
    assert kept == {f"digest-{name}" for name in (NAMES[8], NAMES[1], NAMES[0])}
    assert not any(full_robot.incoming.iterdir())


def test_failed_releases_displace_no_healthy_ones(full_robot: Layout) -> None:
    for name in NAMES[:6]:
        HealthResult(HEALTHY).write(full_robot.releases / name)
    make_current(full_robot, NAMES[5])
    assert push_actions.prune_releases(full_robot) == (NAMES[6], NAMES[0])


def test_newest_current_and_previous_releases_and_those_of_a_pending_check_are_kept(full_robot: Layout) -> None:
    files.write_file(full_robot.health_check, f'{{"release": "{NAMES[3]}", "previous": "{NAMES[2]}"}}')
    assert push_actions.prune_releases(full_robot, keep=2) == tuple(reversed(NAMES[4:7]))
    assert releases.list_names(full_robot) == list(reversed(NAMES[:4] + NAMES[7:]))


OURS, ANOTHERS = 1234, 4321


@pytest.fixture(autouse=True)
def _processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two processes in the format of Debian 12: one of the service, one of a login."""
    groups = {OURS: "user@1000.service/app.slice/robotcore.service", ANOTHERS: "session-15.scope"}
    for pid, group in groups.items():
        (tmp_path / "proc" / str(pid)).mkdir(parents=True)
        (tmp_path / "proc" / str(pid) / "cgroup").write_text(f"0::/user.slice/user-1000.slice/{group}\n")
    monkeypatch.setattr(push_actions, "_PROC", tmp_path / "proc")


def run_doctor(layout: Layout, source: str) -> list[dict[str, Any]]:
    folder = send_release(layout, NEW, doctor=source)
    (folder / ENVIRONMENT / "bin").mkdir(parents=True)
    (folder / ENVIRONMENT / "bin" / "python").symlink_to(sys.executable)
    return push_actions.run_doctor(folder, Release.read(folder))


def print_finding(said: str) -> str:
    row = {"about": "raspberrypi", "level": "error", "subject": "pins", "message": said, "remedy": "End that program"}
    return f"print({json.dumps(json.dumps({'findings': [row]}))})"


@pytest.mark.parametrize(
    "holder, level",
    [
        (f"process {OURS} (python)", "ok"),
        (f"process {ANOTHERS} (python)", "error"),
        (f"process {OURS} (x) or process {ANOTHERS} (y)", "error"),
        ("process 9 (z)", "error"),
        ("unknown", "error"),
    ],
)
def test_only_a_pin_of_the_running_release_is_no_error(layout: Layout, holder: str, level: str) -> None:
    (row,) = run_doctor(layout, print_finding(f"GPIO 17 (left) is held by {holder}"))
    assert (row["level"], row["remedy"]) == (level, "" if level == "ok" else "End that program")
    assert row["message"].startswith("GPIO 17 (left) is held by")


@pytest.mark.parametrize(
    "source, said",
    [
        ("import nothing_of_that_name", "does not run: ModuleNotFoundError: No module named 'nothing_of_that_name'"),
        ("import os; os.abort()", "does not run: it ended with status -6"),
        ("print('junk')", "does not run: it ended with status 0"),
    ],
)
def test_a_doctor_that_does_not_run_is_a_finding(layout: Layout, source: str, said: str) -> None:
    (row,) = run_doctor(layout, source)
    assert (row["level"], row["message"]) == ("error", said)


def test_a_doctor_that_hangs_is_a_finding(layout: Layout, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(push_actions, "DOCTOR_TIMEOUT_S", 0.1)
    (row,) = run_doctor(layout, "import time; time.sleep(60)")
    assert row["message"] == "has not ended within 0.1 s"
