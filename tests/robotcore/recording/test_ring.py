"""The ring of a flight recorder: what it keeps, its limits, killed processes, full disks."""

from __future__ import annotations

import errno
import os
import random
import signal
import subprocess
import sys
import threading
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader

from robotcore.errors import RecordingError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.recording import Recording, read
from robotcore.recording.mcap_file import McapFile
from robotcore.recording.reader import skip_incomplete_beginning
from robotcore.recording.recorder import Recorder
from robotcore.recording.replay import evaluate, replay
from robotcore.recording.ring import Ring
from robotcore.recording.segments import append_segments, has_segments, locate_segments
from robotcore.runtime.result import Outcome
from robotcore.runtime.session import RunRequest, run
from robotcore.runtime.trace import TickRecord
from tests.robotcore.recording.conftest import IRREGULAR_APP
from tests.robotcore.runs import CallOnce, Watcher
from tests.texts import Raises

LONG = RunRequest("avoid-obstacles", settings={"duration_s": 15})


def record_ring(file: Path, *watchers: Watcher, request: RunRequest = LONG, **limits: Any) -> Recorder:
    recorder = Recorder(file, **{"last_s": 5.0, **limits})
    run(request, [recorder, *watchers], [recorder.layer])
    return recorder


class DiskUsage(Watcher):
    """Measures the greatest size of all files of a recording."""

    def __init__(self, file: Path) -> None:
        super().__init__()
        self._file, self.largest = file, 0

    def tick(self, record: TickRecord) -> None:
        self.measure()

    def measure(self) -> int:
        """Return the size of all files, in bytes."""
        size = sum(map(_measure, (self._file, *locate_segments(self._file).glob("*"))))
        self.largest = max(self.largest, size)
        return size


def _measure(file: Path) -> int:
    with suppress(FileNotFoundError):  # the ring has deleted it in the meantime
        return file.stat().st_size
    return 0


@pytest.fixture
def often_flushed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotcore.recording.recorder.FLUSH_S", 0.0)


@pytest.fixture(scope="module")
def ring_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robotcore.recording.recorder.FLUSH_S", 0.0)
        file = tmp_path_factory.mktemp("ring") / "run.mcap"
        record_ring(file)
    return file


@pytest.fixture(scope="module")
def ring(ring_file: Path) -> Recording:
    return read(ring_file)


def test_a_ring_keeps_the_end_of_the_run(ring: Recording) -> None:
    assert ring.ticks[-1].time == pytest.approx(15.0, abs=0.1)
    assert 5.0 <= ring.ticks[-1].time - ring.ticks[0].time < 6.6
    assert (ring.is_cut, ring.damage) == (False, "")
    assert ring.result
    assert ring.result.outcome is Outcome.SUCCESS


def test_the_segments_become_one_file(ring_file: Path) -> None:
    assert list(ring_file.parent.iterdir()) == [ring_file]


def test_other_readers_find_each_message_by_the_index(ring_file: Path, ring: Recording) -> None:
    with ring_file.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary
        assert summary.statistics
        topics = [channel.topic for _, channel, _ in reader.iter_messages()]
        assert summary.statistics.message_count == len(topics)
        assert topics.count("/ticks") >= len(ring.ticks)
        assert {"/run", "/result", "/nose", "/log"} <= {channel.topic for channel in summary.channels.values()}
        assert {each.name for each in reader.iter_attachments()} == {"robot.json", "world.json"}
        assert {each.name for each in reader.iter_metadata()} == {"robotcore.run", "robotcore.result"}


def test_each_read_of_the_remaining_ticks_has_its_sample(ring: Recording) -> None:
    keys = [read.key for tick in ring.ticks for read in tick.reads]
    assert keys
    assert all(key in ring.samples for key in keys)


def test_first_ticks_whose_samples_were_deleted_are_left_out(ring: Recording) -> None:
    ticks = list(ring.ticks)
    deleted = {read.key for read in ticks[0].reads}
    assert skip_incomplete_beginning(ticks, set(ring.samples) - deleted) == ticks[1:]
    assert skip_incomplete_beginning(ticks, set()) == ticks


def test_a_ring_without_the_beginning_is_evaluated_and_not_replayed(ring: Recording, raises: Raises) -> None:
    with raises(RecordingError, "recording-not-replayable", hide=[f"{ring.ticks[0].time:.1f} s"]):
        replay(ring, "run.mcap")
    evaluation = evaluate(ring, "avoid-obstacles", {"duration_s": 15})
    assert evaluation.ticks == len(ring.ticks)


@pytest.mark.slow
def test_the_recorder_and_the_reader_name_the_same_beginning(file: Path) -> None:
    recorder = record_ring(file)
    assert recorder.begins_s == read(file).ticks[0].time


@pytest.mark.slow
def test_a_ring_that_is_longer_than_the_run_is_a_whole_recording(file: Path) -> None:
    recorder = record_ring(file, request=RunRequest(IRREGULAR_APP, settings={"ticks": 40}), last_s=3600.0)
    recording = read(file)
    assert (recorder.begins_s, len(recording.ticks), recording.is_cut) == (None, 40, False)
    assert replay(recording).is_equal


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_a_channel_that_was_last_used_in_a_deleted_segment_can_still_be_read(file: Path) -> None:
    record_ring(file, last_s=2.0)
    with file.open("rb") as opened:
        summary = make_reader(opened).get_summary()
        assert summary
        counts = summary.statistics.channel_message_counts if summary.statistics else {}
        assert set(counts) <= set(summary.channels)
        assert all(channel.schema_id in summary.schemas for channel in summary.channels.values())


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_all_files_together_stay_within_the_limit(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    limit, usage, unlink = 900_000, DiskUsage(file), Path.unlink

    def measure(self: Path, *, missing_ok: bool = False) -> None:
        usage.measure()
        unlink(self, missing_ok=missing_ok)

    monkeypatch.setattr(Path, "unlink", measure)
    record_ring(file, usage, request=RunRequest("green-search", seed=7), last_s=3600.0, limit=limit)
    assert limit // 2 < usage.largest <= limit
    assert limit // 2 < file.stat().st_size <= limit
    recording = read(file)
    assert recording.ticks[0].number > 0
    assert recording.result


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_an_emergency_stop_closes_the_ring(file: Path) -> None:
    class Stop(Watcher):
        def begin(self, run: Any) -> None:
            self._emergency = run.emergency

        def tick(self, record: TickRecord) -> None:
            if record.time > 10.0:
                self._emergency.press("a test")

    record_ring(file, Stop())
    recording = read(file)
    assert recording.result
    assert (recording.result.outcome, recording.result.exit_status) == (Outcome.STOPPED, 4)
    assert recording.ticks[0].number > 0
    assert recording.ticks[-1].error


@pytest.mark.slow
def test_a_killed_ring_is_joined_when_it_is_read(file: Path) -> None:
    command = [sys.executable, "-m", "tests.robotcore.recording.recording_run", str(file), "60"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        lines = ["0.0"]
        while float(lines[-1]) < 3.0:
            lines.append(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
        lines += process.stdout.read().split()
    assert has_segments(file)
    recording = read(file)
    assert not has_segments(file)
    assert (recording.is_cut, recording.damage, recording.ticks[0].number) == (True, "", 0)
    assert float(lines[-1]) - recording.ticks[-1].time < 1.2
    assert replay(recording).is_equal


def test_a_ring_that_is_being_written_is_not_joined(file: Path, raises: Raises) -> None:
    class Reading(Watcher):
        def tick(self, record: TickRecord) -> None:
            if record.tick == 10:
                with raises(RecordingError, "recording-in-progress"):
                    read(file)
                for last_s in (5.0, None):
                    with raises(RecordingError, "recording-in-progress"):
                        Recorder(file, last_s=last_s)._open_file()

    record_ring(file, Reading(), request=RunRequest(IRREGULAR_APP, settings={"ticks": 20}))
    assert len(read(file).ticks) == 20


def _leave_segments(file: Path, monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Record a ring whose segments are not joined, as after a kill. Return the segments."""
    with monkeypatch.context() as patch:
        patch.setattr("robotcore.recording.ring.append_segments", lambda *_: None)
        record_ring(file)
    return sorted(locate_segments(file).iterdir())


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
@pytest.mark.parametrize("calls", [1, 3])
def test_joining_continues_after_it_was_interrupted(file: Path, monkeypatch: pytest.MonkeyPatch, calls: int) -> None:
    segments, copy = _leave_segments(file, monkeypatch), os.fsync

    def interrupt(handle: int) -> None:
        nonlocal calls
        calls -= 1
        if not calls:
            raise KeyboardInterrupt
        copy(handle)

    with monkeypatch.context() as patch:
        patch.setattr("robotcore.recording.segments.os.fsync", interrupt)
        with pytest.raises(KeyboardInterrupt):
            read(file)
    assert len(segments) > 5
    assert has_segments(file)
    recording = read(file)
    numbers = [tick.number for tick in recording.ticks]
    assert numbers == list(range(numbers[0], 301))
    assert recording.damage == ""


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_the_incomplete_end_of_the_last_segment_is_left_out(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    last = _leave_segments(file, monkeypatch)[-1]
    os.truncate(last, last.stat().st_size - 5)
    recording = read(file)
    assert recording.damage == ""
    assert recording.ticks[-1].number > 280


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_a_file_that_is_no_recording_is_not_changed(
    file: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    _leave_segments(file, monkeypatch)
    file.write_bytes(b"something else")
    with raises(RecordingError, "not-a-recording"):
        read(file)
    assert file.read_bytes() == b"something else"


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_a_linked_segment_is_refused(file: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    first = _leave_segments(file, monkeypatch)[0]
    first.rename(file.parent / "elsewhere")
    first.symlink_to(file.parent / "elsewhere")
    with raises(RecordingError, "segments-not-joined"):
        read(file)


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_a_missing_recording_of_segments_is_named(file: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    _leave_segments(file, monkeypatch)
    file.unlink()
    with raises(RecordingError, "segments-not-joined"):
        read(file)


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_segments_on_a_disk_that_cannot_be_written_are_not_joined(
    small_disk: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    file = small_disk / "run.mcap"
    _leave_segments(file, monkeypatch)
    command = ["mount", "-o", "remount,ro", str(small_disk)]
    subprocess.run(command, check=True)
    with raises(RecordingError, "segments-not-joined"):
        read(file)


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_a_new_recording_deletes_the_segments_of_the_old_one(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _leave_segments(file, monkeypatch)
    recorder = Recorder(file)
    run(RunRequest(IRREGULAR_APP, settings={"ticks": 5}), [recorder], [recorder.layer])
    assert not has_segments(file)
    assert len(read(file).ticks) == 5


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_a_full_disk_makes_the_ring_smaller(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    room = 250_000
    usage = DiskUsage(file)

    def write_all(opened: Any, data: bytes) -> None:
        if usage.measure() + len(data) > room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        opened.write(data)

    for name in ("ring", "segments", "file_index"):
        monkeypatch.setattr(f"robotcore.recording.{name}.write_all", write_all)
    recorder = record_ring(file, last_s=3600.0)
    assert recorder.failure is None
    assert file.stat().st_size <= room
    recording = read(file)
    assert recording.ticks[0].number > 0
    assert recording.result
    assert recording.ticks[-1].number == 300


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_a_real_robot_does_not_wait_for_the_disk(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    has_begun, has_answered, waits = threading.Event(), threading.Event(), []

    def sync(_: int) -> None:
        if has_begun.is_set():
            waits.append(has_answered.wait(60.0))

    class Disk(Watcher):
        def tick(self, record: TickRecord) -> None:
            has_begun.set()
            if record.tick == 250:
                has_answered.set()

    monkeypatch.setattr("robotcore.hal.clock.SteppedClock.is_lockstep", False)
    monkeypatch.setattr("robotcore.recording.ring.os.fsync", sync)
    recorder = record_ring(file, Disk())
    assert waits
    assert all(waits)
    assert recorder.failure is None
    assert read(file).ticks[-1].number == 300


@pytest.mark.usefixtures("often_flushed")
def test_an_error_of_the_disk_ends_the_recording_and_not_the_run(
    file: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    def fail(*_: object) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    breaking = CallOnce(lambda: monkeypatch.setattr("robotcore.recording.ring.write_all", fail))
    recorder = record_ring(file, breaking)
    assert recorder.failure
    with raises(RecordingError, "file-not-writable"):
        raise recorder.failure
    assert not has_segments(file)
    read(file)


@pytest.mark.usefixtures("often_flushed")
def test_a_slow_join_is_reported(file: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    may_join = threading.Event()

    def join(*arguments: Any) -> None:
        may_join.wait(60.0)
        append_segments(*arguments)

    monkeypatch.setattr("robotcore.recording.ring.append_segments", join)
    monkeypatch.setattr("robotcore.recording.recorder.JOIN_S", 0.1)
    recorder = record_ring(file, request=RunRequest(IRREGULAR_APP, settings={"ticks": 5}))
    with raises(RecordingError, "segments-not-joined"):
        raise recorder.failure or AssertionError
    may_join.set()
    assert recorder._thread
    recorder._thread.join()
    assert len(read(file).ticks) == 5


@pytest.mark.slow
@pytest.mark.usefixtures("often_flushed")
def test_metadata_and_segments_are_synced_to_the_disk_during_the_run(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced, sync = list[str](), os.fsync

    def collect(handle: int) -> None:
        synced.append(Path(f"/proc/self/fd/{handle}").readlink().name)
        sync(handle)

    monkeypatch.setattr("robotcore.recording.ring.SYNC_S", 0.0)
    monkeypatch.setattr("robotcore.recording.ring.os.fsync", collect)
    record_ring(file, request=RunRequest(IRREGULAR_APP, settings={"ticks": 40}))
    assert synced[0] == "run.mcap"
    assert synced.count("00000001") > 1


@pytest.mark.usefixtures("often_flushed")
@pytest.mark.posix("Windows lacks O_NOFOLLOW")
def test_a_link_that_replaces_a_recording_is_not_followed(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = file.with_name("other.txt")
    other.write_text("text")

    def replace(path: Path) -> None:
        path.symlink_to(other)

    monkeypatch.setattr("robotcore.recording.segments.require_regular", replace)
    with pytest.raises(RecordingError):
        Recorder(file)._open_file()
    assert other.read_text() == "text"


def test_a_fast_simulation_is_flushed_on_the_clock_of_the_robot(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class StoppedClock(MonotonicClock):
        def now(self) -> float:
            return 0.0

    monkeypatch.setattr("robotcore.recording.recorder.MonotonicClock", StoppedClock)
    record_ring(file, request=RunRequest("avoid-obstacles", settings={"duration_s": 5}))
    with file.open("rb") as opened:
        summary = make_reader(opened).get_summary()
    assert summary
    assert len(summary.chunk_indexes) >= 10


def _write_in_ring(file: Path, limit: int, messages: Iterable[bytes], monkeypatch: pytest.MonkeyPatch) -> int:
    """Write each message to a chunk of its own. Return the greatest size of all files."""
    usage, unlink = DiskUsage(file), Path.unlink

    def measure(self: Path, *, missing_ok: bool = False) -> None:
        usage.measure()
        unlink(self, missing_ok=missing_ok)

    output = McapFile(file, Ring(file, 3600.0, limit))
    output.flush()
    write = output.open_json_channel("/text", {"type": "object"})
    for number, message in enumerate(messages):
        write(message, number * 10_000_000)
        output.flush()
        usage.measure()
    monkeypatch.setattr(Path, "unlink", measure)
    output.close()
    usage.measure()
    return usage.largest


def test_a_ring_has_room_for_the_joining_of_large_chunks(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    noise = (random.Random(number).randbytes(1_000_000).hex().encode() for number in range(20))
    assert 5_000_000 < _write_in_ring(file, 8_000_000, noise, monkeypatch) <= 8_000_000


@pytest.mark.slow
def test_a_ring_has_room_for_the_index_of_many_small_chunks(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert 500_000 < _write_in_ring(file, 1_000_000, [b"{}"] * 8000, monkeypatch) <= 1_000_000
