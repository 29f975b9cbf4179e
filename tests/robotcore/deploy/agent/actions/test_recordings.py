from __future__ import annotations

import os
from hashlib import sha256

from robotcore.deploy.agent.actions import erase, recordings
from robotcore.deploy.agent.layout import Layout


def test_a_robot_that_never_ran_has_none(layout: Layout) -> None:
    assert recordings.act(layout) == {"recordings": []}


def test_what_somebody_still_writes_is_told(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    (layout.recordings / "ended 'ü'.mcap").write_bytes(b"whole")
    with (layout.recordings / "running.mcap").open("wb") as file:
        file.write(b"half")
        file.flush()
        told = recordings.act(layout)["recordings"]
    assert told == [
        {"name": "ended 'ü'.mcap", "bytes": 5, "is_file": True, "is_being_written": False},
        {"name": "running.mcap", "bytes": 4, "is_file": True, "is_being_written": True},
    ]
    assert not any(each["is_being_written"] for each in recordings.act(layout)["recordings"])


def test_what_nothing_was_written_into_is_none_once_nobody_writes_it(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    with (layout.recordings / "begun.mcap").open("wb"):
        assert [each["name"] for each in recordings.act(layout)["recordings"]] == ["begun.mcap"]
    assert recordings.act(layout) == {"recordings": []}


def test_links_folders_and_names_that_are_not_text_are_listed_for_the_desk_to_name(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    (layout.recordings / "folder").mkdir()
    (layout.recordings / "link.mcap").symlink_to("/etc/hostname")
    (layout.recordings / os.fsdecode(b"\xff.mcap")).write_bytes(b"x")
    listed = recordings.act(layout)["recordings"]
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
        told = erase.act(layout, recordings={**asked, "other.mcap": "0" * 64})
    assert told == {"erased": ["same.mcap"], "different": ["other.mcap"]}
    assert {path.name for path in layout.recordings.iterdir()} == {"other.mcap", "written.mcap", "link.mcap"}
    assert (layout.root / "outside.mcap").exists()
