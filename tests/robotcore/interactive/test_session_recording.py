"""The recordings of sessions."""

from __future__ import annotations

from pathlib import Path

import pytest

import robotcore
from robotcore import LiveRobot, Routine, RunResult
from robotcore.errors import RecordingError
from robotcore.kinds.range_sensor import RangeSensor
from robotcore.recording import Recording, read
from robotcore.recording.recorder import Recorder
from tests.texts import CheckText, Raises


def test_session_is_recorded(tmp_path: Path) -> None:
    file = tmp_path / "session.mcap"
    with robotcore.open(world="open", record=file) as robot:
        robot.drive.straight(0.2)
        robot.wait(0.2)
    assert robot.result
    recording = read(file)
    assert len(recording.ticks) == robot.result.ticks
    assert {"straight", "wait"} == {tick.state for tick in recording.ticks}
    assert all(tick.reads for tick in recording.ticks)


def test_recording_of_a_session_can_keep_only_its_end(tmp_path: Path) -> None:
    file = tmp_path / "session.mcap"
    with robotcore.open(world="open", record=file, record_last_s=1.0) as robot:
        robot.wait(6.0)
    recording = read(file)
    assert recording.ticks[0].time > 0
    assert 1.0 <= recording.ticks[-1].time - recording.ticks[0].time < 5.0


def test_session_is_recorded_after_an_error(tmp_path: Path) -> None:
    file = tmp_path / "session.mcap"
    with robotcore.open(world="open", record=file) as robot:
        with pytest.raises(ZeroDivisionError):
            robot.wait_until(lambda: 1 / 0)
        robot.drive.move(0.1, seconds=0.1)
    assert [tick for tick in read(file).ticks if tick.state == "move"][-2].asks


def test_recording_that_exists_is_not_overwritten(tmp_path: Path, raises: Raises) -> None:
    file = tmp_path / "session.mcap"
    file.write_text("old")
    with raises(RecordingError, "recording-exists"):
        robotcore.open(record=file)
    assert file.read_text() == "old"
    with robotcore.open(record=file, force=True) as robot:
        robot.wait(0.1)
    assert read(file).ticks


def read_devices(robot: LiveRobot) -> None:
    for name in ("nose", "eye", "left_encoder"):
        robot[name].read()  # type: ignore[attr-defined]  # all three are sensors
    assert robot.drive.pose


def record_drive(file: Path, *, has_reads: bool) -> tuple[RunResult, Recording]:
    with robotcore.open(world="arena", seed=7, faults="range noise=0.05", record=file) as robot:
        for angle in (0.3, -0.2):
            robot.drive.turn(angle)
            if has_reads:
                read_devices(robot)
    assert robot.result
    return robot.result, read(file)


def test_reads_between_two_calls_change_no_bit_of_the_recording(tmp_path: Path) -> None:
    plain, recorded = record_drive(tmp_path / "plain.mcap", has_reads=False)
    result, recorded_beside_reads = record_drive(tmp_path / "reads.mcap", has_reads=True)
    assert result.trace_sha256 == plain.trace_sha256
    assert recorded_beside_reads.ticks == recorded.ticks
    assert dict(recorded_beside_reads.samples) == dict(recorded.samples)
    assert not recorded_beside_reads.is_damaged


def test_reads_between_two_calls_use_no_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recorders: list[Recorder] = []

    def build(file: Path, *, last_s: float | None) -> Recorder:
        recorders.append(Recorder(file, last_s=last_s))
        return recorders[-1]

    monkeypatch.setattr("robotcore.interactive.opening.Recorder", build)
    with robotcore.open(world="open", record=tmp_path / "session.mcap") as robot:
        read_devices(robot)
        robot.wait(0.1)
        read_devices(robot)
        (recorder,) = recorders
        events = recorder.layer.events
        assert (events.reads, events.samples, events.turned) == ([], [], [])


def test_result_of_a_session_has_the_notes_of_its_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, check_text: CheckText
) -> None:
    monkeypatch.setattr(RangeSensor, "list_rays", lambda *_: None)
    file = tmp_path / "session.mcap"
    with robotcore.open(world="open", record=file) as robot:
        robot.wait(0.1)
    assert robot.result
    assert robot.result == read(file).result
    assert robot.result.dropped_pictures == 0
    (note,) = robot.result.notes
    check_text(note)


def test_close_raises_the_error_of_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    robot = robotcore.open(world="open", record=tmp_path / "session.mcap")
    monkeypatch.setattr("robotcore.recording.recorder.RecordingWriter.end", lambda *_: 1 / 0)
    with pytest.raises(RecordingError, match="ZeroDivisionError"):
        robot.close()
    robot.close()
    assert robot.result


def test_value_that_is_logged_between_two_calls_is_in_the_next_tick(tmp_path: Path) -> None:
    def log_twice(robot: LiveRobot) -> Routine[None]:
        robot.log("inside", 1)
        yield
        robot.log("inside", 2)

    file = tmp_path / "run.mcap"
    with robotcore.open("rover", world="open", record=file) as robot:
        robot.log("between", True)
        robot.run(log_twice(robot))
    recorded = [(name, each.value) for values in read(file).logged.values() for name, each in values.items()]
    assert recorded == [("between", True), ("inside", 1), ("inside", 2)]
