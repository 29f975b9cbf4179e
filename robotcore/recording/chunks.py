"""The chunks of an MCAP file, as far as they are whole: each is read, checked by its checksum, and can be read again.

The format: https://mcap.dev/spec.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Chunk, DataEnd, McapRecord
from mcap.stream_reader import breakup_chunk
from zstandard import ZstdError

from robotcore.errors import RecordingError

MAGIC = b"\x89MCAP0\r\n"
DAMAGE = (McapError, ZstdError, struct.error, ValueError, LookupError, OverflowError, RecursionError)
"""What comes of bytes that are not what was written."""

_RECORD = struct.Struct("<BQ")
_MOST_BYTES = 2**28
"""No chunk of ours is larger unpacked: a size that is, has been damaged."""


@dataclass(frozen=True)
class Place:
    """Where a chunk's packed data stands in the file, and what its record says of it."""

    offset: int
    length: int
    chunk: Chunk = field(compare=False)


class ChunkedFile:
    """Goes through a file; ``is_whole`` tells, after that, whether its end was reached and nothing was amiss.

    ``is_damaged`` tells whether something is not what was written, which is more than an end that is not there.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.is_whole = self.is_damaged = False

    def chunks(self) -> Iterator[tuple[Place, list[McapRecord]]]:
        """Yield each chunk and what is in it, until the end or the first that is damaged.

        Raises RecordingError where the file cannot be read, or is no MCAP file.
        """
        try:
            with self._path.open("rb") as file:
                if file.read(len(MAGIC)) != MAGIC:
                    raise RecordingError(self._path, "it is no MCAP file", "Name one that robotcore has recorded")
                yield from self._chunks(file)
        except OSError as error:
            raise _unreadable(self._path, error) from error

    def again(self, place: Place) -> list[McapRecord]:
        """Return what is in a chunk. Raises RecordingError where it is no longer what it was."""
        try:
            with self._path.open("rb") as file:
                file.seek(place.offset)
                return _unpacked(replace(place.chunk, data=file.read(place.length)))
        except OSError as error:
            raise _unreadable(self._path, error) from error
        except DAMAGE as error:
            raise RecordingError(self._path, "it has changed since it was opened", "Open it again") from error

    def _chunks(self, file: BinaryIO) -> Iterator[tuple[Place, list[McapRecord]]]:
        crc = zlib.crc32(MAGIC)
        for opcode, head, body in _records(file):
            if opcode == Opcode.DATA_END:
                written = DataEnd.read(ReadDataStream(BytesIO(body))).data_section_crc
                self.is_whole = written in (0, crc) and _ends_well(file)
                self.is_damaged = written not in (0, crc)
                return
            crc = zlib.crc32(body, zlib.crc32(head, crc))
            if opcode == Opcode.CHUNK:
                try:
                    chunk = Chunk.read(ReadDataStream(BytesIO(body)))
                    records = _unpacked(chunk)
                except DAMAGE:
                    self.is_damaged = True
                    return
                length = len(chunk.data)
                yield Place(file.tell() - length, length, replace(chunk, data=b"")), records
        self.is_damaged = file.seek(0, 2) > len(MAGIC) and _ends_well(file)


def _records(file: BinaryIO) -> Iterator[tuple[int, bytes, bytes]]:
    """Yield kind, head and body of each record that is there in full."""
    size = file.seek(0, 2)
    file.seek(len(MAGIC))
    while len(head := file.read(_RECORD.size)) == _RECORD.size:
        opcode, length = _RECORD.unpack(head)
        if length > size - file.tell():
            return
        yield opcode, head, file.read(length)


def _ends_well(file: BinaryIO) -> bool:
    """Return whether the last magic is there, which comes after the index."""
    file.seek(-len(MAGIC), 2)
    return file.read() == MAGIC


def _unpacked(chunk: Chunk) -> list[McapRecord]:
    if chunk.uncompressed_size > _MOST_BYTES:
        raise ValueError("a chunk is too large")
    return breakup_chunk(chunk, validate_crc=True)


def _unreadable(path: Path, error: OSError) -> RecordingError:
    return RecordingError(path, str(error.strerror), "Name a recording that can be read")
