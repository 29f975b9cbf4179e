from __future__ import annotations

import os
import sys
from hashlib import sha256

import pytest

from robotcore.deploy.agent import admin_actions, files
from robotcore.deploy.agent.errors import AgentError
from robotcore.deploy.agent.files import Layout, locate_segments
from robotcore.deploy.agent.releases import ENVIRONMENT, HEALTHY, SITE, HealthResult
from robotcore.deploy.agent.systemd_units import HEALTH_CHECK, SERVICE, UNIT_TEXTS
from tests.robotcore.deploy.agent import systemd_states as at
from tests.robotcore.deploy.agent.sample_releases import NEW, OLD, make_current, put_release, put_releases, read_files
from tests.robotcore.deploy.agent.systemd_double import ScriptedSystemd


def test_releases_are_listed_newest_first_with_their_results(layout: Layout) -> None:
    HealthResult(HEALTHY, "it ended with success").write(put_release(layout, OLD))
    put_release(layout, NEW)
    (layout.releases / "notes").mkdir()
    make_current(layout, OLD)
    files.write_file(layout.health_check, f'{{"release": "{NEW}", "previous": "{OLD}"}}')
    answer = admin_actions.list_releases(layout)
    assert (answer["current"], answer["pending"]) == (OLD, NEW)
    assert [each["name"] for each in answer["releases"]] == [NEW, OLD]
    assert [each["outcome"] for each in answer["releases"]] == [None, "healthy"]
    assert answer["releases"][1]["app"] == "my 'robot'.py"


def test_release_of_another_format_is_listed_as_unreadable(layout: Layout) -> None:
    file = put_release(layout, OLD) / "release.json"
    file.write_text(file.read_text().replace('"format": 1', '"format": 2'))
    (answer,) = admin_actions.list_releases(layout)["releases"]
    assert answer["name"] == OLD
    assert answer["unreadable"] == "release.json has the format 2; this robotcore reads 1"


def test_links_folders_and_recordings_that_are_being_written_are_marked(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    (layout.recordings / os.fsdecode("ended 'ü' ".encode() + b"\xff.mcap")).write_bytes(b"whole")
    (layout.recordings / "empty.mcap").touch()
    (layout.recordings / "folder").mkdir()
    (layout.recordings / "link.mcap").symlink_to("/etc/hostname")
    with (layout.recordings / "running.mcap").open("wb") as file:
        file.write(b"half")
        file.flush()
        answer = admin_actions.list_recordings(layout)["recordings"]
    assert [(each["name"], each["is_file"], each["is_being_written"]) for each in answer] == [
        ("ended 'ü' \\xff.mcap", True, False),
        ("folder", False, False),
        ("link.mcap", False, False),
        ("running.mcap", True, True),
    ]
    assert (answer[0]["bytes"], answer[-1]["bytes"]) == (5, 4)
    assert not any(each["is_being_written"] for each in admin_actions.list_recordings(layout)["recordings"])


def test_recordings_are_listed_while_a_process_has_the_root_folder_open(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    (layout.recordings / "run.mcap").write_bytes(b"whole")
    root = os.open("/", os.O_RDONLY)
    try:
        (listed,) = admin_actions.list_recordings(layout)["recordings"]
    finally:
        os.close(root)
    assert (listed["name"], listed["is_being_written"]) == ("run.mcap", False)


def test_segments_of_a_killed_run_are_joined_by_the_current_release(layout: Layout) -> None:
    folder = put_release(layout, OLD)
    folder.joinpath(ENVIRONMENT, "bin").mkdir()
    folder.joinpath(ENVIRONMENT, "bin", "python").symlink_to(sys.executable)
    joins = "import sys, shutil; assert sys.argv[1:3] == ['info', '--json']; shutil.rmtree(sys.argv[3] + '.segments')"
    folder.joinpath(SITE, "robotcore", "__main__.py").write_text(joins)
    make_current(layout, OLD)
    for name in ("killed.mcap", "running.mcap"):
        locate_segments(layout.recordings / name).mkdir(parents=True)
        (layout.recordings / name).write_bytes(b"begin")
    with (layout.recordings / "running.mcap").open("ab"):
        answer = admin_actions.list_recordings(layout)["recordings"]
    assert [(each["name"], each["is_being_written"]) for each in answer] == [
        ("killed.mcap", False),
        ("running.mcap", True),
    ]
    assert [path.name for path in layout.recordings.glob("*.segments")] == ["running.mcap.segments"]


def test_only_closed_recordings_with_equal_content_are_erased(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    for name in ("same.mcap", "other.mcap", "written.mcap"):
        (layout.recordings / name).write_bytes(b"content")
    (layout.recordings / "link.mcap").symlink_to("same.mcap")
    (layout.root / "outside.mcap").write_bytes(b"content")
    digest = sha256(b"content").hexdigest()
    asked = dict.fromkeys(("same.mcap", "written.mcap", "link.mcap", "gone.mcap", "../outside.mcap"), digest)
    with (layout.recordings / "written.mcap").open("ab"):
        answer = admin_actions.erase_recordings(layout, recordings={**asked, "other.mcap": "0" * 64})
    assert answer == {"erased": ["same.mcap"], "different": ["other.mcap"]}
    assert {path.name for path in layout.recordings.iterdir()} == {"other.mcap", "written.mcap", "link.mcap"}
    assert (layout.root / "outside.mcap").exists()


@pytest.fixture
def robot(layout: Layout) -> Layout:
    put_releases(layout, OLD, current=OLD)
    layout.recordings.mkdir()
    (layout.recordings / "run.mcap").touch()
    layout.units.mkdir(parents=True)
    for name, text in UNIT_TEXTS.items():
        (layout.units / name).write_text(text)
    return layout


def test_app_is_stopped_before_anything_is_deleted(robot: Layout, systemd: ScriptedSystemd) -> None:
    assert admin_actions.remove_robotcore(robot) == {"removed": True, "has_recordings": True}
    assert systemd.calls[0] == f"stop {SERVICE} {HEALTH_CHECK}"
    assert systemd.calls[-1] == "daemon-reload"
    assert read_files(robot.home) == {"robotcore/recordings/run.mcap": b""}


def test_recordings_are_deleted_only_on_request(robot: Layout, systemd: ScriptedSystemd) -> None:
    assert admin_actions.remove_robotcore(robot, keeps_recordings=False) == {"removed": True, "has_recordings": False}
    assert not robot.root.exists()
    assert admin_actions.remove_robotcore(robot) == {"removed": False, "has_recordings": False}


@pytest.mark.parametrize("refused", ["stop", "disable"])
def test_nothing_is_deleted_if_the_app_does_not_stop(robot: Layout, systemd: ScriptedSystemd, refused: str) -> None:
    before = read_files(robot.home)
    systemd.fail(refused, at.NO_BUS)
    with pytest.raises(AgentError):
        admin_actions.remove_robotcore(robot)
    assert read_files(robot.home) | {"robotcore/lock": b""} == before | {"robotcore/lock": b""}


def test_second_removal_completes_an_interrupted_one(robot: Layout, systemd: ScriptedSystemd) -> None:
    (robot.units / SERVICE).unlink()
    assert admin_actions.remove_robotcore(robot)["removed"]
    assert not any(robot.units.iterdir())


def test_removal_after_a_broken_first_push_stops_nothing(layout: Layout, systemd: ScriptedSystemd) -> None:
    (layout.incoming / OLD).mkdir(parents=True)
    assert admin_actions.remove_robotcore(layout) == {"removed": True, "has_recordings": False}
    assert not systemd.calls
    assert not layout.root.exists()
