"""The ring of a flight recorder: the newest minutes of a run on the disk, in segments of some seconds."""

from __future__ import annotations

import os
import zlib
from collections import deque
from dataclasses import dataclass
from io import FileIO
from math import inf
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema

from robotcore.files import write_all
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.recording.chunks import MAGIC, RECORD, locate_chunk, read_records, unpack
from robotcore.recording.file_index import CHANNEL_INDEX_BYTES, INDEX_BYTES, take_bytes
from robotcore.recording.mcap_file import build_unwritable_error, create_recording
from robotcore.recording.segments import (
    DISK_FULL,
    append_segments,
    build_join_error,
    locate_segments,
    measure_free_space,
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
    files. The first error is stored in ``error``, and all later bytes are discarded. If the disk is full, the ring
    becomes smaller.

    path: the recording. An existing file is overwritten.
    last_s: the time that the ring holds at least, in seconds on the robot's clock.
    limit: the size that all files of the recording have together at most, in bytes; None for the free space of the
        disk, which is a limit too. The newest chunk and the metadata of the run are kept even if they are larger.
    """

    def __init__(self, path: Path, last_s: float, limit: int | None = None) -> None:
        self.error: OSError | None = None
        self.dropped_until_s: float | None = None
        """The time of the last message that was deleted, in seconds; None if the ring has the whole run."""
        self._path, self._last_s = path, last_s
        self._segment_s = min(max(last_s / SEGMENTS, _SHORTEST_SEGMENT_S), _LONGEST_SEGMENT_S)
        self._begun_s = 0.0
        self._file = create_recording(path)
        try:
            locate_segments(path).mkdir(exist_ok=True)
        except OSError as error:
            self._file.close()
            raise build_unwritable_error(path, error) from error
        self._limit = min(inf if limit is None else limit, measure_free_space(self._file))
        self._segments: deque[_Segment] = deque()
        self._newest: FileIO | None = None
        self._number = 0
        self._unparsed = bytearray()
        self._chunk = b""
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
            if self._newest:
                self._newest.close()
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
            self._end()
            return
        if not self._has_metadata:
            self._add_metadata(record)
        else:
            if opcode == Opcode.CHUNK:
                self._begin_chunk(record)
            self._write_newest(record)
        if opcode == Opcode.MESSAGE_INDEX:
            self._keep_definitions(int.from_bytes(record[RECORD.size : RECORD.size + 2], "little"))

    def _end(self, error: OSError | None = None) -> None:
        self.error, self._is_over = error, True

    def _add_metadata(self, record: bytes) -> None:
        write_all(self._file, record)
        self._metadata_size += len(record)
        if record[0] == Opcode.CHUNK:
            os.fsync(self._file.fileno())

    def _begin_chunk(self, record: bytes) -> None:
        """Delete the segments that are too old, and begin a new segment if the newest one is complete."""
        self._chunk = record
        end_s = locate_chunk(record[RECORD.size :], 0).end_ns / 1e9
        while len(self._segments) > 1 and end_s - self._segments[0].end_s >= self._last_s + self._segment_s:
            self._drop_oldest()
        newest = self._segments[-1] if self._segments else None
        if newest is None or end_s - self._begun_s >= self._segment_s or newest.size >= self._limit / SEGMENTS:
            self._begun_s = newest.end_s if newest else 0.0
            newest = self._begin_segment()
        newest.end_s = end_s
        newest.index_size += INDEX_BYTES

    def _begin_segment(self) -> _Segment:
        if self._newest:
            os.fsync(self._newest.fileno())
            self._newest.close()
        self._number += 1
        segment = _Segment(locate_segments(self._path) / f"{self._number:08d}")
        self._newest = segment.file.open("xb", buffering=0)
        self._segments.append(segment)
        return segment

    def _write_newest(self, record: bytes) -> None:
        """Append a record to the newest segment. If the disk is full, delete the oldest segments."""
        if not self._newest:
            return
        newest = self._segments[-1]
        newest.index_size += CHANNEL_INDEX_BYTES
        self._make_room(len(record))
        while not self._try_write(self._newest, record, newest.size):
            self._limit = self.size
            self._make_room(len(record))
        newest.size += len(record)

    def _try_write(self, file: FileIO, record: bytes, at: int) -> bool:
        """Write a record at an offset. Return False if the disk is full and an older segment can be deleted."""
        try:
            write_all(file, record)
        except OSError as error:
            if error.errno not in DISK_FULL or len(self._segments) == 1:
                raise
            file.seek(at)
            file.truncate()
            return False
        return True

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
        oldest.file.unlink()
        self.dropped_until_s = oldest.end_s

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
        self._add_metadata(take_bytes(builder))
