"""Flight recorders on a disk of 6 MB that another program fills."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from io import FileIO
from pathlib import Path

import pytest

from robotcore.errors import RecordingError
from robotcore.files import write_all
from robotcore.recording import read
from robotcore.recording.recorder import Recorder
from robotcore.recording.segments import locate_segments
from robotcore.runtime.session import RunRequest, run
from robotcore.runtime.trace import TickRecord
from tests.robotcore.runs import CallOnce, Watcher
from tests.texts import Raises

APP = """
from robotcore import Behaviour, Role, Status

class Looking(Behaviour):
    needs = frozenset({Role.CAMERA, Role.DRIVE})

    def step(self, robot):
        now = robot.clock.now()
        robot.camera.read()
        robot.drive.set_velocity(0.1, 0.5)
        if now >= 5.0:
            robot.log("late", now, "s")
        return Status.RUNNING
"""


class OtherProgram(Watcher):
    """Fills the disk in each tick of an interval of a run, and then deletes its file."""

    def __init__(self, disk: Path, begin_s: float, end_s: float) -> None:
        super().__init__()
        self._file, self._begin_s, self._end_s = disk / "other", begin_s, end_s

    def tick(self, record: TickRecord) -> None:
        if self._begin_s <= record.time < self._end_s:
            with self._file.open("ab", buffering=0) as file, suppress(OSError):
                while file.write(bytes(4096)):
                    pass
        elif record.time >= self._end_s:
            self._file.unlink(missing_ok=True)


@pytest.fixture
def looking_app(tmp_path: Path) -> str:
    app = tmp_path / "looking.py"
    app.write_text(APP)
    return str(app)


def record_beside(other: Watcher, file: Path, app: str, timeout_s: float = 15.0) -> Recorder:
    recorder = Recorder(file, last_s=3600.0)
    run(RunRequest(app, timeout_s=timeout_s), [recorder, other], [recorder.layer])
    return recorder


@pytest.mark.slow
def test_a_ring_grows_again_after_another_program_has_filled_the_disk(small_disk: Path, looking_app: str) -> None:
    file = small_disk / "run.mcap"
    recorder = record_beside(OtherProgram(small_disk, 4.0, 6.0), file, looking_app)
    assert recorder.failure is None
    recording = read(file)
    numbers = [tick.number for tick in recording.ticks]
    assert numbers == list(range(numbers[0], 301))
    assert 3.0 < recording.ticks[0].time < 7.0
    assert recording.damage == ""
    assert recording.result
    assert all("late" in recording.logged[tick.number] for tick in recording.ticks if tick.time >= 5.0)


@pytest.mark.slow
def test_a_disk_that_stays_full_is_reported(small_disk: Path, looking_app: str, raises: Raises) -> None:
    file = small_disk / "run.mcap"
    recorder = record_beside(OtherProgram(small_disk, 4.0, 100.0), file, looking_app)
    assert recorder.failure
    with raises(RecordingError, "segments-not-joined"):
        raise recorder.failure
    assert recorder.begins_s == pytest.approx(15.0, abs=0.6)
    (small_disk / "other").unlink()
    assert not read(file).ticks


def test_a_recording_without_its_end_is_reported(
    file: Path, looking_app: str, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    def write_small(opened: FileIO, data: bytes) -> None:
        if len(data) > 500:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        opened.write(data)

    fill = CallOnce(lambda: monkeypatch.setattr("robotcore.recording.ring.write_all", write_small))
    recorder = record_beside(fill, file, looking_app, timeout_s=1.0)
    assert recorder.failure
    with raises(RecordingError, "file-not-writable"):
        raise recorder.failure


@pytest.mark.slow
def test_a_channel_that_begins_while_the_disk_is_full_can_be_read(
    file: Path, looking_app: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = 3

    def write_half(opened: FileIO, data: bytes) -> None:
        nonlocal left
        has_segments = any(segment.stat().st_size for segment in locate_segments(file).iterdir())
        if Path(os.fsdecode(opened.name)) != file or not left:
            return write_all(opened, data)
        left -= not has_segments
        opened.write(data[: len(data) // 2])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    fill = CallOnce(lambda: monkeypatch.setattr("robotcore.recording.ring.write_all", write_half), tick=50)
    recorder = record_beside(fill, file, looking_app, timeout_s=10.0)
    assert recorder.failure is None
    assert not left
    recording = read(file)
    assert recording.damage == ""
    assert recording.ticks[-1].number == 200
    assert recorder.begins_s == recording.ticks[0].time
    assert all("late" in recording.logged[tick.number] for tick in recording.ticks)
