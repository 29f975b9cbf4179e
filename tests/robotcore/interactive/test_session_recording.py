"""The recordings of sessions."""

from __future__ import annotations

from pathlib import Path

import pytest

import robotcore
from robotcore.errors import RecordingError
from robotcore.recording import read
from tests.texts import Raises


def test_session_is_recorded(tmp_path: Path) -> None:
    file = tmp_path / "session.mcap"
    with robotcore.open(world="open", record=file) as robot:
        robot.drive.straight(0.2)
        robot.wait(0.2)
    assert robot.result
    recording = read(file)
    assert len(recording.ticks) == robot.result.ticks
    assert {"straight", "wait"} == {tick.state for tick in recording.ticks}


def test_session_is_recorded_after_an_error(tmp_path: Path) -> None:
    file = tmp_path / "session.mcap"
    with robotcore.open(world="open", record=file) as robot:
        with pytest.raises(ZeroDivisionError):
            robot.wait_until(lambda: 1 / 0)
        robot.drive.move(0.1, seconds=0.1)
    assert [tick for tick in read(file).ticks if tick.state == "move"][-2].asked


def test_recording_that_exists_is_not_overwritten(tmp_path: Path, raises: Raises) -> None:
    file = tmp_path / "session.mcap"
    file.write_text("old")
    with raises(RecordingError, "recording-exists"):
        robotcore.open(record=file)
    assert file.read_text() == "old"
