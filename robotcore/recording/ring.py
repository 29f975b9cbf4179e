"""The ring of a flight recorder: the newest minutes of a run on the disk, in segments of some seconds."""

from __future__ import annotations

import os
import zlib
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from io import FileIO
from math import inf
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema

from robotcore.files import measure_free_space, write_all
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.recording.chunks import MAGIC, RECORD, locate_chunk, read_records, unpack
from robotcore.recording.file_index import CHANNEL_INDEX_BYTES, INDEX_BYTES, take_bytes
from robotcore.recording.mcap_file import build_unwritable_error, create_recording
from robotcore.recording.segments import (
    DISK_FULL,
    append_segments,
    build_join_error,
    locate_segments,
)

SYNC_S = 1.0
"""The interval at which the newest segment is synced to the disk, in seconds. A power cut loses what came later."""

SEGMENTS = 60
"""The number of segments in a full ring."""

MIN_LIMIT_BYTES = 10_000_000
"""The smallest size limit of a ring that a user can set, in bytes: some chunks with pictures."""

_SHORTEST_SEGMENT_S, _LONGEST_SEGMENT_S = 0.5, 10.0
_SUMMARY_BYTES = 100_000
"""The assumed size of the schemas and channels at the end of the finished file, in bytes."""


@dataclass
class _Segment:
    file: Path
    size: int = 0
    """The size in bytes."""
    index_size: int = 0
    """The size of the index of its chunks in the finished file, in bytes."""
    end_s: float = 0.0
    """The time of its last message on the robot's clock, in seconds."""


class Ring:
    """The file object to which foxglove-sdk writes a ring recording. It deletes the oldest segments.

    The chunks before the first flush have the metadata of the run, and are never deleted. `segments` describes the
    files. The first error is stored in ``error``, and all later bytes are discarded. While the disk is full, the ring
    is smaller, and a chunk for which it has no room is lost.

    path: the recording. An existing file is overwritten.
    last_s: the time that the ring holds at least, in seconds on the robot's clock.
    limit: the size that all files of the recording have together at most, in bytes; None for the free space of the
        disk, which is a limit too. The newest chunk and the metadata of the run are kept even if they are larger.
    """

    def __init__(self, path: Path, last_s: float, limit: int | None = None) -> None:
        self.error: OSError | None = None
        self.dropped_until_s: float | None = None
        """The time of the last message that was deleted or lost, in seconds; None if the ring has the whole run."""
        self._path, self._last_s = path, last_s
        self._segment_s = min(max(last_s / SEGMENTS, _SHORTEST_SEGMENT_S), _LONGEST_SEGMENT_S)
        self._begun_s = 0.0
        self._file = create_recording(path)
        try:
            locate_segments(path).mkdir(exist_ok=True)
        except OSError as error:
            self._file.close()
            raise build_unwritable_error(path, error) from error
        self._greatest_limit = self._limit = inf if limit is None else limit
        self._segments: deque[_Segment] = deque()
        self._newest: FileIO | None = None
        self._number = 0
        self._unparsed = bytearray()
        self._chunk, self._chunk_end_s = b"", 0.0
        self._definitions = b""
        self._loss: OSError | None = None
        """The error because of which the ring does not have the newest chunk."""
        self._channels: set[int] = set()
        self._written = self._metadata_size = 0
        self._has_metadata = self._is_over = False
        self._clock, self._sync_due = MonotonicClock(), 0.0

    @property
    def size(self) -> int:
        """The size of all files of the recording, in bytes."""
        return self._metadata_size + sum(each.size for each in self._segments)

    def write(self, data: bytes | bytearray) -> int:
        self._written += len(data)
        self._unparsed += data
        try:
            while not self._is_over and (record := self._take_record()):
                self._add(record)
        except OSError as error:
            self._end(error)
        if self._is_over:
            self._unparsed.clear()
        return len(data)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Return the position. The writer appends only."""
        return self._written

    def flush(self) -> None:
        """End the metadata at the first call. Sync the newest segment at intervals."""
        self._has_metadata = True
        if self._newest and not self.error and self._clock.now() >= self._sync_due:
            try:
                os.fsync(self._newest.fileno())
            except OSError as error:
                self._end(error)
            self._sync_due = self._clock.now() + SYNC_S

    def close(self) -> None:
        """Join the segments into the file. Raises RecordingError if this is not possible. Later calls do nothing."""
        if self._file.closed:
            return
        try:
            self._close_newest()
            append_segments(self._path, self._file)
        except OSError as error:
            raise build_join_error(self._path, error) from error
        finally:
            self._file.close()

    def _take_record(self) -> bytes:
        """Return the next complete record; empty if there is none. The magic bytes of the file count as one."""
        if self._metadata_size == 0:
            length = len(MAGIC)
        elif len(self._unparsed) < RECORD.size:
            return b""
        else:
            length = RECORD.size + RECORD.unpack_from(self._unparsed)[1]
        if len(self._unparsed) < length:
            return b""
        record = bytes(self._unparsed[:length])
        del self._unparsed[:length]
        return record

    def _add(self, record: bytes) -> None:
        opcode = record[0]
        if self._metadata_size and opcode == Opcode.DATA_END:
            self._end(self._loss)
            return
        if not self._has_metadata:
            self._add_metadata(record)
        else:
            if opcode == Opcode.CHUNK:
                self._begin_chunk(record)
            self._write_or_shrink(partial(self._append, record))
        if opcode == Opcode.MESSAGE_INDEX:
            self._keep_definitions(int.from_bytes(record[RECORD.size : RECORD.size + 2], "little"))

    def _end(self, error: OSError | None = None) -> None:
        self.error, self._is_over = error, True

    def _add_metadata(self, record: bytes) -> None:
        _write_at(self._file, record, self._metadata_size)
        self._metadata_size += len(record)
        if record[0] == Opcode.CHUNK:
            os.fsync(self._file.fileno())

    def _begin_chunk(self, record: bytes) -> None:
        """Delete the segments that are too old, and end the newest one if it is complete."""
        self._chunk = record
        self._chunk_end_s = end_s = locate_chunk(record[RECORD.size :], 0).end_ns / 1e9
        while len(self._segments) > 1 and end_s - self._segments[0].end_s >= self._last_s + self._segment_s:
            self._drop_oldest()
        if self._newest and (
            end_s - self._begun_s >= self._segment_s or self._segments[-1].size >= self._limit / SEGMENTS
        ):
            os.fsync(self._newest.fileno())
            self._close_newest()

    def _begin_segment(self) -> FileIO:
        self._limit = min(self._greatest_limit, self.size + measure_free_space(self._file))
        self._begun_s = self._segments[-1].end_s if self._segments else self.dropped_until_s or 0.0
        self._number += 1
        segment = _Segment(locate_segments(self._path) / f"{self._number:08d}")
        self._newest = segment.file.open("xb", buffering=0)
        self._segments.append(segment)
        return self._newest

    def _append(self, record: bytes) -> None:
        """Append a record to the newest segment, or discard it if its chunk is lost."""
        is_chunk = record[0] == Opcode.CHUNK
        if not self._newest and not is_chunk:
            return
        self._add_definitions()
        file = self._newest or self._begin_segment()
        newest = self._segments[-1]
        newest.end_s = self._chunk_end_s
        self._make_room(len(record))
        _write_at(file, record, newest.size)
        newest.size += len(record)
        newest.index_size += INDEX_BYTES if is_chunk else CHANNEL_INDEX_BYTES
        self._loss = None

    def _write_or_shrink(self, write: Callable[[], None]) -> None:
        """Write. If the disk is full, delete the oldest segment and try again until the ring is empty."""
        while error := _try(write):
            self._limit = self.size
            is_empty = self.size == self._metadata_size
            if self._segments:
                self._drop_oldest()
            if not self._segments:
                self._loss = error
            if is_empty:
                self.dropped_until_s = self._chunk_end_s
                return

    def _make_room(self, size: int) -> None:
        """Delete the oldest segments until the limit has room for ``size`` bytes, the index and the joining."""
        while len(self._segments) > 1:
            largest = max(each.size for each in self._segments)
            index = _SUMMARY_BYTES + sum(each.index_size for each in self._segments)
            if self.size + size + index + largest <= self._limit:
                return
            self._drop_oldest()

    def _drop_oldest(self) -> None:
        oldest = self._segments.popleft()
        if not self._segments:
            self._close_newest()  # an open file keeps its room on the disk
        oldest.file.unlink()
        self.dropped_until_s = oldest.end_s

    def _close_newest(self) -> None:
        if self._newest:
            self._newest.close()
            self._newest = None

    def _keep_definitions(self, channel: int) -> None:
        """Add the schemas and channels of the newest chunk to the metadata if it is the first with this channel."""
        if channel in self._channels:
            return
        self._channels.add(channel)
        if not self._has_metadata:
            return  # the chunk itself is kept
        body = memoryview(self._chunk)[RECORD.size :]
        location = locate_chunk(bytes(body), 0).location
        builder = RecordBuilder()
        for record in read_records(unpack(location, body[location.offset :][: location.length])):
            if isinstance(record, Channel):
                self._channels.add(record.id)
            if isinstance(record, (Schema, Channel)):
                record.write(builder)
        data = take_bytes(builder)
        Chunk("", data, 0, 0, zlib.crc32(data), len(data)).write(builder)
        self._definitions += take_bytes(builder)
        self._write_or_shrink(self._add_definitions)

    def _add_definitions(self) -> None:
        """Add the new schemas and channels to the metadata. Without them, later chunks could not be read."""
        if self._definitions:
            self._add_metadata(self._definitions)
            self._definitions = b""


def _try(write: Callable[[], None]) -> OSError | None:
    """Write. Return the error if the disk is full."""
    try:
        write()
    except OSError as error:
        if error.errno not in DISK_FULL:
            raise
        return error
    return None


def _write_at(file: FileIO, data: bytes, at: int) -> None:
    """Write all bytes at an offset. A part may be there from a write that has failed."""
    file.seek(at)
    write_all(file, data)
