"""The recorder: killed processes, full disks, limits, and its queue."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from robotcore.errors import BackendMissingError, DeviceError, Interrupted, RecordingError, UsageError
from robotcore.hal.device import Rays
from robotcore.kinds.range_sensor import RangeSensor
from robotcore.recording import read
from robotcore.recording.mcap_file import McapFile, require_recordable
from robotcore.recording.recorder import Recorder, WriteQueue
from robotcore.recording.tap import RecordingTap
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import RunRequest, run
from robotcore.runtime.trace import TickRecord
from tests.doubles.foreign_kinds import Tilt
from tests.robotcore.recording.conftest import IRREGULAR_APP, record
from tests.robotcore.runs import CallOnce, Watcher
from tests.texts import CheckText, Raises


@pytest.mark.slow
def test_killed_process_loses_only_the_last_moment(file: Path) -> None:
    command = [sys.executable, "-m", "tests.robotcore.recording.recording_run", str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        lines = ["0.0"]
        while float(lines[-1]) < 1.5:
            lines.append(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
        lines += process.stdout.read().split()
    recording = read(file)
    assert recording.is_cut
    assert recording.is_replayable
    assert float(lines[-1]) - recording.ticks[-1].time < 1.2


def test_first_tick_is_in_the_file_at_once(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flushes: queue.Queue[int] = queue.Queue()
    flush = McapFile.flush

    def count_flush(self: McapFile) -> None:
        flush(self)
        flushes.put(len(read(file).ticks))

    class Waiting(Watcher):
        def tick(self, record: TickRecord) -> None:
            if record.tick == 0:
                assert [flushes.get(timeout=100) for _ in range(2)] == [0, 1]

    monkeypatch.setattr(McapFile, "flush", count_flush)
    recorder = Recorder(file)
    run(RunRequest(IRREGULAR_APP), [recorder, Waiting()], [recorder.layer])


def test_recording_of_an_interrupted_run_is_whole(file: Path) -> None:
    recorder = Recorder(file)
    interrupt = CallOnce(lambda: signal.raise_signal(signal.SIGTERM))
    result = run(RunRequest(IRREGULAR_APP), [recorder, interrupt], [recorder.layer])
    assert result.outcome is Outcome.INTERRUPTED
    recording = read(file)
    assert (recording.is_cut, recorder.failure) == (False, None)
    assert recording.result
    assert recording.result.exit_status == 143


def test_signal_before_the_metadata_leaves_a_closed_file(
    raises: Raises, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise Interrupted(signal.SIGINT)

    monkeypatch.setattr("robotcore.recording.recorder.RecordingWriter", interrupted)
    recorder = Recorder(file)
    assert run(RunRequest(IRREGULAR_APP), [recorder], [recorder.layer]).outcome is Outcome.INTERRUPTED
    assert (recorder.has_begun, recorder.failure) == (False, None)
    with raises(RecordingError, "recording-without-run"):
        read(file)


@pytest.mark.slow
@pytest.mark.posix("it limits the size of files")
@pytest.mark.parametrize("limit", [100, 20_000])
def test_full_disk_ends_the_recording_and_not_the_run(
    raises: Raises, file: Path, capfd: pytest.CaptureFixture[str], limit: int
) -> None:
    import resource

    recorder, limits = Recorder(file), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limits[1]))
    try:
        result = run(RunRequest(IRREGULAR_APP, settings={"ticks": 100}), [recorder], [recorder.layer])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (result.ticks, capfd.readouterr().err) == (100, "")
    assert file.stat().st_size <= limit
    assert recorder.failure
    with raises(RecordingError, "file-not-writable"):
        raise recorder.failure


@pytest.mark.slow
@pytest.mark.parametrize("is_lockstep", [True, False])
def test_limit_ends_the_recording_and_not_the_run(
    file: Path, monkeypatch: pytest.MonkeyPatch, is_lockstep: bool
) -> None:
    monkeypatch.setattr("robotcore.hal.clock.SteppedClock.is_lockstep", is_lockstep)
    recorder, limit = Recorder(file, limit=200_000), 200_000
    result = run(RunRequest(IRREGULAR_APP, settings={"ticks": 400}), [recorder], [recorder.layer])
    assert (result.ticks, recorder.failure, recorder.dropped) == (400, None, 0)
    assert limit <= file.stat().st_size < 2 * limit
    recording = read(file)
    assert (recording.is_cut, recording.is_damaged, recording.result) == (False, False, None)
    assert recording.is_replayable
    last = recording.ticks[-1].time
    assert recording.ended_early == (
        f"the recording reached its size limit of 0.2 MB at {last:.1f} s, before the end of the run"
    )
    assert recorder.ended_early == recording.ended_early


@pytest.mark.parametrize("error", [TypeError("a bug"), UsageError("a bug")], ids=["any error", "own error"])
def test_bug_of_the_writer_ends_the_recording_and_not_the_run(
    file: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    def failing(*_: object) -> None:
        raise error

    monkeypatch.setattr("robotcore.recording.writer.to_json", failing)
    recorder = Recorder(file)
    assert run(RunRequest(IRREGULAR_APP), [recorder], [recorder.layer]).ticks == 8
    assert recorder.failure
    assert recorder.failure.kind == "recorder-bug"


@pytest.mark.parametrize("list_rays", [lambda *_: 1 / 0, lambda *_: None], ids=["fails", "none"])
def test_rays_that_cannot_be_listed_are_a_note_of_a_whole_recording(
    file: Path, monkeypatch: pytest.MonkeyPatch, list_rays: Callable[..., Rays], check_text: CheckText
) -> None:
    monkeypatch.setattr(RangeSensor, "list_rays", list_rays)
    recorder = Recorder(file)
    result = run(RunRequest(IRREGULAR_APP), [recorder], [recorder.layer])
    recording = read(file)
    assert (recorder.failure, recording.is_cut, len(recording.ticks)) == (None, False, result.ticks)
    assert recording.result == recorder.complete(result)
    (note,) = recorder.complete(result).notes
    check_text(note)


def test_simulated_time_waits_for_a_slow_disk(file: Path) -> None:
    recorder = Recorder(file, room=1)
    run(RunRequest(IRREGULAR_APP), [recorder], [recorder.layer])
    assert recorder.dropped == 0
    assert read(file).is_replayable


def test_real_robot_does_not_wait_for_a_slow_disk(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.hal.clock.SteppedClock.is_lockstep", False)
    recorder = Recorder(file, room=0)
    result = run(RunRequest(IRREGULAR_APP), [recorder], [recorder.layer])
    recording = read(file)
    assert len(recording.ticks) == result.ticks == 8
    assert recorder.dropped == 16  # the camera's and those shown
    assert recording.missing_inputs == "8 picture(s) are missing, because the disk was too slow"
    assert all(each.device != "eye" for each in recording.samples)


def mkfifo(file: Path) -> None:
    os.mkfifo(file)


@pytest.mark.parametrize(
    "name, spoil, kind",
    [
        ("run.txt", lambda _: None, "file-ending"),
        ("gone/run.mcap", lambda _: None, "file-not-writable"),
        ("run.mcap", Path.mkdir, "file-not-writable"),
        pytest.param("run.mcap", mkfifo, "file-not-writable", marks=pytest.mark.posix("a FIFO")),
        ("run.mcap", lambda file: file.symlink_to("own.mcap"), "file-not-writable"),
    ],
)
def test_unwritable_file_is_refused_before_the_run(
    raises: Raises, tmp_path: Path, name: str, spoil: Callable[[Path], None], kind: str
) -> None:
    spoil(tmp_path / name)
    with raises(RecordingError, kind):
        require_recordable(tmp_path / name)
    if kind == "file-not-writable":
        recorder = Recorder(tmp_path / name)
        assert run(RunRequest(IRREGULAR_APP), [recorder], [recorder.layer]).ticks == 8
        assert recorder.failure
        assert recorder.failure.kind == kind


@pytest.mark.slow
def test_check_for_writing_keeps_the_file_and_the_recording_overwrites_it(file: Path) -> None:
    require_recordable(file)
    assert not file.exists()
    file.write_bytes(b"x" * 10**6)
    require_recordable(file, is_forced=True)
    assert file.stat().st_size == 10**6
    assert not record(file).recording.is_cut
    assert file.stat().st_size < 10**6


@pytest.mark.parametrize("ask", [require_recordable, read])
def test_missing_extra_is_reported(
    raises: Raises, file: Path, monkeypatch: pytest.MonkeyPatch, ask: Callable[[Path], object]
) -> None:
    monkeypatch.setattr("robotcore.extras.find_spec", lambda _: None)
    with raises(BackendMissingError, "library-missing", extra="record", modules=["foxglove", "mcap"]):
        ask(file)


@pytest.mark.parametrize("finish", [WriteQueue.get, WriteQueue.end])
def test_waiting_put_returns_when_there_is_room_or_the_queue_ends(finish: Callable[[WriteQueue[int]], object]) -> None:
    backlog: WriteQueue[int] = WriteQueue(room=10)
    putting = threading.Thread(target=lambda: backlog.put(1, 10, is_blocking=True))
    putting.start()
    while not backlog._entries:
        pass
    assert putting.is_alive()
    finish(backlog)
    putting.join(20.0)
    assert not putting.is_alive()


def test_queue_keeps_the_order_accepts_entries_if_full_and_discards_them_after_its_end() -> None:
    backlog: WriteQueue[int] = WriteQueue(room=10)
    for entry in range(3):
        assert backlog.has_room() == (entry < 2)
        backlog.put(entry, 9, is_blocking=False)
    assert backlog.get() == 0
    backlog.end()
    backlog.put(4, 9, is_blocking=True)
    assert (backlog.has_room(), backlog.get(), backlog.is_over) == (True, 1, False)
    assert (backlog.get(), backlog.get(), backlog.is_over) == (2, None, True)


def test_recorded_sample_that_does_not_fit_its_types_is_an_error_of_the_device(raises: Raises) -> None:
    tap, wrong = RecordingTap(lambda: True), Tilt(0.1, 0.2, cast("int", 0.5), 0.0, 0)
    read_recorded = tap.sensor(cast("Any", SimpleNamespace(name="tilt")), lambda: wrong)
    with raises(DeviceError, "sample-types", device="tilt"):
        read_recorded()
    assert [each.error is not None for each in tap.events.reads] == [True]
