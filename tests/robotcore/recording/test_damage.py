from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from robotcore.errors import RecordingError
from robotcore.kinds.camera import Frame
from robotcore.recording import Recording, read
from robotcore.recording.chunks import MAGIC, ChunkedFile
from tests.robotcore.recording.conftest import RecordedRun, record
from tests.robotcore.recording.mcap_builder import change_json
from tests.robotcore.recording.test_codec import get_bits
from tests.texts import Raises

HUGE = MAGIC + b"\x06" + (56).to_bytes(8, "little") + bytes(32) + b"\xff" * 8 + bytes(16)
"""A chunk whose header states a size larger than any memory."""


def require_first_part(part: Recording, whole: Recording) -> None:
    """Fail unless ``part`` has the first ticks of ``whole`` and the same samples."""
    assert get_bits(tuple(part.ticks)) == get_bits(tuple(whole.ticks[: len(part.ticks)]))
    for key in part.samples:
        try:
            sample = part.samples[key]
        except RecordingError:
            continue
        expected = whole.samples[key]
        if isinstance(sample, Frame):
            assert isinstance(expected, Frame)
            assert sample.image.tobytes() == expected.image.tobytes()
            assert (sample.time, sample.sequence) == (expected.time, expected.sequence)
        else:
            assert get_bits(sample) == get_bits(expected)


def read_or_refuse(file: Path, whole: Recording) -> Recording | None:
    try:
        part = read(file)
    except RecordingError:
        return None
    require_first_part(part, whole)
    return part


@pytest.fixture(scope="module")
def short_run(tmp_path_factory: pytest.TempPathFactory) -> RecordedRun:
    """Return a small recording, for tests with many examples."""
    return record(tmp_path_factory.mktemp("short") / "run.mcap", is_jpeg=True)


@pytest.mark.slow
def test_file_cut_after_any_chunk_has_the_ticks_before(recorded: RecordedRun, file: Path) -> None:
    whole, content = recorded.recording, recorded.file.read_bytes()
    ends = [place.offset + place.length for place, _ in ChunkedFile(recorded.file).chunks()]
    lengths = []
    for end in ends:
        file.write_bytes(content[:end])
        part = read(file)
        require_first_part(part, whole)
        assert (part.is_cut, part.is_damaged) == (True, False)
        lengths.append(len(part.ticks))
    assert lengths == sorted(lengths)
    assert lengths[-1] == len(whole.ticks)
    assert len(set(lengths)) > 3


def _flip_byte(content: bytearray, at: int) -> None:
    content[at] ^= 1


def _flip_bytes(content: bytearray, at: int) -> None:
    """Change eight bytes, because a single bit may be padding of the compression."""
    for number in range(8):
        _flip_byte(content, at + number)


def _flip_length(content: bytearray, first: int, end: int) -> None:
    """Change the length of a chunk's record, which ends 40 bytes before the packed data of a chunk by zstd."""
    _flip_byte(content, content.rindex(b"\x06", 0, first - 40) + 7)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda content, first, end: _flip_bytes(content, (first + end) // 2),
        _flip_length,
        lambda content, first, end: content.__delitem__(slice(first, end)),
    ],
    ids=["byte", "length", "chunk"],
)
def test_damaged_chunk_ends_the_recording_before_it(
    recorded: RecordedRun, file: Path, spoil: Callable[[bytearray, int, int], object]
) -> None:
    content = bytearray(recorded.file.read_bytes())
    place = [place for place, _ in ChunkedFile(recorded.file).chunks()][3]
    spoil(content, place.offset, place.offset + place.length)
    file.write_bytes(content)
    part = read(file)
    require_first_part(part, recorded.recording)
    assert (part.is_cut, part.is_damaged) == (True, True)
    assert 0 < len(part.ticks) < len(recorded.recording.ticks)
    assert all(read.key in part.samples for tick in part.ticks for read in tick.reads if read.key)


def test_damage_before_the_first_tick_is_not_reported_as_a_cut(recorded: RecordedRun, file: Path) -> None:
    content = bytearray(recorded.file.read_bytes())
    place, _ = next(ChunkedFile(recorded.file).chunks())
    content[place.offset + place.length // 2] ^= 1
    for spoiled, kind in ((content, "recording-damaged"), (content[: place.offset], "recording-cut")):
        file.write_bytes(spoiled)
        with pytest.raises(RecordingError) as caught:
            read(file)
        assert caught.value.kind == kind


@pytest.mark.slow
def test_file_cut_at_any_byte_is_read_or_refused(short_run: RecordedRun, file: Path) -> None:
    whole, content = short_run.recording, short_run.file.read_bytes()
    for length in sorted(random.Random(7).sample(range(len(content)), 150)):
        file.write_bytes(content[:length])
        if part := read_or_refuse(file, whole):
            assert part.is_cut


@pytest.mark.slow
def test_flipped_bytes_add_no_content(short_run: RecordedRun, file: Path) -> None:
    whole, numbers = short_run.recording, random.Random(7)
    for _ in range(200):
        content = bytearray(short_run.file.read_bytes())
        for _ in range(numbers.randint(1, 3)):
            content[numbers.randrange(len(content))] ^= numbers.randint(1, 255)
        file.write_bytes(content)
        read_or_refuse(file, whole)


@pytest.mark.parametrize(
    "content", [None, b"", b"PNG", MAGIC, MAGIC + b"\x06" + b"\xff" * 8, MAGIC + bytes(99), HUGE], ids=range(7)
)
def test_file_without_a_recording_is_refused(file: Path, content: bytes | None) -> None:
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(RecordingError) as caught:
        read(file)
    assert caught.value.kind in {"recording-unreadable", "not-a-recording", "recording-cut", "recording-damaged"}
    assert caught.value.fields["file"] == str(file)


def test_file_that_changes_after_it_was_opened_is_refused(raises: Raises, file: Path) -> None:
    recording = record(file).recording
    key = next(key for key in recording.samples if key.device == "eye")
    file.write_bytes(MAGIC + bytes(file.stat().st_size))
    with raises(RecordingError, "recording-changed", file=str(file)):
        recording.samples[key]


def test_recording_of_a_kind_that_is_not_installed_names_the_kind(
    short_run: RecordedRun, file: Path, raises: Raises
) -> None:
    content = change_json(short_run.file, "/run", lambda _number, run: _rename_kind(run, "range_sensor", "sonar_array"))
    file.write_bytes(content)
    with raises(RecordingError, "recording-kind", name="sonar_array", file=str(file)):
        read(file)


def _rename_kind(metadata: Any, kind: str, name: str) -> Any:
    for device in metadata["description"]["devices"]:
        if device["kind"] == kind:
            device["kind"] = name
    return metadata
