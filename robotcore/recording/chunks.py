"""The chunks of an MCAP file, as far as they are whole: each is read, checked by its checksum, and can be read again.

Every length in the file is held to what is there, and to the limits of `robotcore.recording.records`.
"""

from __future__ import annotations

import os
import stat
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from mcap.opcode import Opcode

from robotcore.errors import RecordingError
from robotcore.recording.records import (
    DAMAGE,
    MAX_RECORD_BYTES,
    RECORD,
    Allowance,
    ChunkLocation,
    Lz4Error,
    Record,
    damage_at,
    read_records,
    unpack,
)

MAGIC = b"\x89MCAP0\r\n"

_PIECE = 2**20
_NO_KIND = 0
"""No record has this opcode."""
_CHUNK = struct.Struct("<QQQII")
"""Times of the first and the last message, size and checksum of what is in it, length of the compression's name."""
_LENGTH = struct.Struct("<Q")


class ChunkedFile:
    """The chunks of a file. After `chunks`, ``is_whole`` says whether its end was reached without damage.

    ``damage`` is the place and the kind of the first damage, empty if there is none. A missing end is no damage.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.is_whole = False
        self.damage = ""
        self.allowance = Allowance()

    def chunks(self) -> Iterator[tuple[ChunkLocation, Iterator[Record]]]:
        """Yield each chunk and what is in it, until the end or the first that is damaged.

        Reading its records raises one of `DAMAGE` if they are malformed. Raises RecordingError if the file cannot be
        read, or is no MCAP file.
        """
        with _open_regular(self._path) as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise RecordingError(self._path, "it is no MCAP file", "Name one that robotcore has recorded")
            yield from self._chunks(file)

    def again(self, place: ChunkLocation) -> Iterator[Record]:
        """Return the records of a chunk. Raises RecordingError if the file has changed."""
        try:
            with _open_regular(self._path) as file:
                file.seek(place.offset)
                return read_records(unpack(place, file.read(place.length)))
        except RecordingError:
            raise
        except DAMAGE as error:
            raise RecordingError(self._path, "it has changed since it was opened", "Open it again") from error

    def _chunks(self, file: BinaryIO) -> Iterator[tuple[ChunkLocation, Iterator[Record]]]:
        size = os.fstat(file.fileno()).st_size
        crc: int | None = zlib.crc32(MAGIC)
        while len(head := file.read(RECORD.size)) == RECORD.size:
            opcode, length = RECORD.unpack(head)
            at = file.tell()
            if length > size - at or opcode == _NO_KIND:
                if opcode == _NO_KIND or _has_end_magic(file):
                    self._set_damage(at, "a record is of no kind, or longer than the file")
                return
            if opcode == Opcode.DATA_END:
                self._check_file_checksum(file, crc, at)
                return
            crc = None if crc is None else zlib.crc32(head, crc)
            if opcode == Opcode.CHUNK:
                if (chunk := self._chunk(file, length, at)) is None:
                    return
                place, body, data = chunk
                crc = None if crc is None else zlib.crc32(body, crc)
                yield place, read_records(data, self.allowance)
            else:
                if opcode == Opcode.MESSAGE_INDEX and length <= MAX_RECORD_BYTES:
                    self.allowance.grow(length)
                crc = _skip_record(file, length, crc)
        if size > len(MAGIC) and _has_end_magic(file):
            self._set_damage(size + RECORD.size, "the end of its data is missing")

    def _chunk(
        self, file: BinaryIO, length: int, at: int
    ) -> tuple[ChunkLocation, memoryview, bytes | memoryview] | None:
        """Return where the data of a chunk stands, its record, and what is in it; None if it is damaged."""
        self.allowance.grow(length)
        try:
            body = _read_chunk(file, length)
            place, packed = _parse_chunk(body, at)
            return place, body, unpack(place, packed)
        except Lz4Error as error:
            remedy = "Pack it with Zstandard: mcap compress --compression zstd"
            raise RecordingError(self._path, "it is packed with lz4", remedy) from error
        except DAMAGE as error:
            self.damage = damage_at(at - RECORD.size, error)
            return None

    def _set_damage(self, at: int, problem: str) -> None:
        self.damage = damage_at(at - RECORD.size, ValueError(problem))

    def _check_file_checksum(self, file: BinaryIO, crc: int | None, at: int) -> None:
        written = int.from_bytes(file.read(4), "little")
        is_same = written == 0 or crc in (None, written)
        self.is_whole = is_same and _has_end_magic(file)
        if not is_same:
            self._set_damage(at, "the checksum of the file is wrong")


@contextmanager
def _open_regular(path: Path) -> Iterator[BinaryIO]:
    """Open a regular file; a FIFO or a device is refused at once."""
    try:
        with open(path, "rb", opener=_open_at_once) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise RecordingError(path, "it is no regular file", "Name one that robotcore has recorded")
            yield file
    except OSError as error:
        raise RecordingError(path, str(error.strerror), "Name a recording that can be read") from error


def _open_at_once(path: str, flags: int) -> int:
    """Open without waiting for the other end of a FIFO."""
    return os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY)


def _skip_record(file: BinaryIO, length: int, crc: int | None) -> int | None:
    """Go to the end of a record; return the checksum with it, or None if the record is too long to be read."""
    if crc is None or length > MAX_RECORD_BYTES:
        file.seek(length, os.SEEK_CUR)
        return None
    while length and (piece := file.read(min(length, _PIECE))):
        crc, length = zlib.crc32(piece, crc), length - len(piece)
    return crc


def _read_chunk(file: BinaryIO, length: int) -> memoryview:
    if length > MAX_RECORD_BYTES:
        raise ValueError(f"a chunk has {length} bytes, more than {MAX_RECORD_BYTES}")
    return memoryview(file.read(length))


def _parse_chunk(body: memoryview, at: int) -> tuple[ChunkLocation, memoryview]:
    """Return where the data of a chunk stands, and the data as they are, packed; the record's body begins ``at``."""
    *_, size, crc, name_length = _CHUNK.unpack_from(body)
    name_end = _CHUNK.size + name_length
    begin = name_end + _LENGTH.size
    (length,) = _LENGTH.unpack_from(body, name_end)
    packed = body[begin : begin + length]
    return ChunkLocation(at + begin, len(packed), size, crc, bytes(body[_CHUNK.size : name_end]).decode()), packed


def _has_end_magic(file: BinaryIO) -> bool:
    """Return whether the last magic is there, which comes after the index."""
    file.seek(-len(MAGIC), os.SEEK_END)
    return file.read() == MAGIC
