from __future__ import annotations

from hashlib import sha256

from robotcore.deploy.aboard.actions import recordings
from robotcore.deploy.aboard.layout import Layout


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
        {"name": "ended 'ü'.mcap", "bytes": 5, "is_being_written": False},
        {"name": "running.mcap", "bytes": 4, "is_being_written": True},
    ]
    assert not any(each["is_being_written"] for each in recordings.act(layout)["recordings"])


def test_what_nothing_was_written_into_is_none_once_nobody_writes_it(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    with (layout.recordings / "begun.mcap").open("wb"):
        assert [each["name"] for each in recordings.act(layout)["recordings"]] == ["begun.mcap"]
    assert recordings.act(layout) == {"recordings": []}


def test_those_that_are_asked_for_are_told_with_what_is_in_them(layout: Layout) -> None:
    layout.recordings.mkdir(parents=True)
    for name in ("one.mcap", "other.mcap"):
        (layout.recordings / name).write_bytes(name.encode())
    one, other = recordings.act(layout, hashed=["one.mcap", "gone.mcap"])["recordings"]
    assert one["sha256"] == sha256(b"one.mcap").hexdigest()
    assert "sha256" not in other
