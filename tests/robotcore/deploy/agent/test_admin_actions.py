from __future__ import annotations

import os
from hashlib import sha256

import pytest

from robotcore.deploy.agent import admin_actions, files
from robotcore.deploy.agent.files import Layout
from robotcore.deploy.agent.releases import HEALTHY, HealthResult
from robotcore.deploy.agent.rpc import AgentError
from robotcore.deploy.agent.units import HEALTH_CHECK, SERVICE, UNIT_TEXTS
from tests.robotcore.deploy.agent import systemd_states as at
from tests.robotcore.deploy.agent.sample_releases import NEW, OLD, make_current, put_release, read_files
from tests.robotcore.deploy.agent.systemd_double import ScriptedSystemd


def test_a_robot_that_nothing_was_put_on_has_none(layout: Layout) -> None:
    assert admin_actions.list_releases(layout) == {"releases": [], "current": None, "on_trial": None}


def test_the_newest_comes_first_each_with_what_came_of_it(layout: Layout) -> None:
    HealthResult(HEALTHY, "it ended with success").write(put_release(layout, OLD))
    put_release(layout, NEW)
    make_current(layout, OLD)
    files.write_file(layout.health_check, f'{{"release": "{NEW}", "previous": "{OLD}"}}')
    answer = admin_actions.list_releases(layout)
    assert (answer["current"], answer["on_trial"]) == (OLD, NEW)
    assert [each["name"] for each in answer["releases"]] == [NEW, OLD]
    assert [each["verdict"] for each in answer["releases"]] == [None, "healthy"]
    assert answer["releases"][1]["app"] == "my 'robot'.py"


def test_a_release_of_another_format_is_reported_as_such(layout: Layout) -> None:
    file = put_release(layout, OLD) / "release.json"
    file.write_text(file.read_text().replace('"format": 1', '"format": 2'))
    (answer,) = admin_actions.list_releases(layout)["releases"]
    assert answer["name"] == OLD
    assert answer["unreadable"] == "release.json has the format 2; this robotcore reads 1"


def test_what_is_no_release_is_none(layout: Layout) -> None:
    put_release(layout, OLD)
    (layout.releases / "notes").mkdir()
    assert [each["name"] for each in admin_actions.list_releases(layout)["releases"]] == [OLD]


def test_a_robot_that_never_ran_has_none(layout: Layout) -> None:
    assert admin_actions.list_recordings(layout) == {"recordings": []}


def test_what_somebody_still_writes_is_reported(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    (layout.recordings / "ended 'ü'.mcap").write_bytes(b"whole")
    with (layout.recordings / "running.mcap").open("wb") as file:
        file.write(b"half")
        file.flush()
        answer = admin_actions.list_recordings(layout)["recordings"]
    assert answer == [
        {"name": "ended 'ü'.mcap", "bytes": 5, "is_file": True, "is_being_written": False},
        {"name": "running.mcap", "bytes": 4, "is_file": True, "is_being_written": True},
    ]
    assert not any(each["is_being_written"] for each in admin_actions.list_recordings(layout)["recordings"])


def test_what_nothing_was_written_into_is_none_once_nobody_writes_it(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    with (layout.recordings / "begun.mcap").open("wb"):
        assert [each["name"] for each in admin_actions.list_recordings(layout)["recordings"]] == ["begun.mcap"]
    assert admin_actions.list_recordings(layout) == {"recordings": []}


def test_links_folders_and_names_that_are_not_text_are_listed_for_the_desk_to_name(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    (layout.recordings / "folder").mkdir()
    (layout.recordings / "link.mcap").symlink_to("/etc/hostname")
    (layout.recordings / os.fsdecode(b"\xff.mcap")).write_bytes(b"x")
    listed = admin_actions.list_recordings(layout)["recordings"]
    assert [(each["name"], each["is_file"]) for each in listed] == [
        ("folder", False),
        ("link.mcap", False),
        ("\\xff.mcap", True),
    ]


def test_only_a_recording_with_the_same_content_that_is_not_being_written_is_erased(layout: Layout) -> None:
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
    put_release(layout, OLD)
    make_current(layout, OLD)
    layout.recordings.mkdir()
    (layout.recordings / "run.mcap").touch()
    layout.units.mkdir(parents=True)
    for name, text in UNIT_TEXTS.items():
        (layout.units / name).write_text(text)
    return layout


def test_what_runs_is_stopped_before_anything_is_taken_away(robot: Layout, systemd: ScriptedSystemd) -> None:
    assert admin_actions.remove_robotcore(robot) == {"removed": True, "kept": True}
    assert systemd.calls[0] == f"stop {SERVICE} {HEALTH_CHECK}"
    assert systemd.calls[-1] == "daemon-reload"
    assert read_files(robot.home) == {"robotcore/recordings/run.mcap": b""}


def test_recordings_go_only_where_that_is_asked_for(robot: Layout, systemd: ScriptedSystemd) -> None:
    assert admin_actions.remove_robotcore(robot, keeps_recordings=False) == {"removed": True, "kept": False}
    assert not robot.root.exists()
    assert admin_actions.remove_robotcore(robot) == {"removed": False, "kept": False}


@pytest.mark.parametrize("refused", ["stop", "disable"])
def test_where_it_does_not_stop_all_is_still_there(robot: Layout, systemd: ScriptedSystemd, refused: str) -> None:
    before = read_files(robot.home)
    systemd.fails(refused, at.NO_BUS)
    with pytest.raises(AgentError):
        admin_actions.remove_robotcore(robot)
    assert read_files(robot.home) | {"robotcore/lock": b""} == before | {"robotcore/lock": b""}


def test_a_removal_that_was_cut_short_is_finished(robot: Layout, systemd: ScriptedSystemd) -> None:
    (robot.units / SERVICE).unlink()
    assert admin_actions.remove_robotcore(robot)["removed"]
    assert not any(robot.units.iterdir())


def test_a_robot_that_a_push_broke_off_on_has_nothing_to_stop(layout: Layout, systemd: ScriptedSystemd) -> None:
    (layout.incoming / OLD).mkdir(parents=True)
    assert admin_actions.remove_robotcore(layout) == {"removed": True, "kept": False}
    assert not systemd.calls
    assert not layout.root.exists()
