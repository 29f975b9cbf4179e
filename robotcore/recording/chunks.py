"""Read the chunks and the records of an MCAP file, which may be hostile.

The format is https://mcap.dev/spec.
"""

from __future__ import annotations

import os
import stat
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from zstandard import CONTENTSIZE_UNKNOWN, ZstdDecompressor, get_frame_parameters

from robotcore.errors import RecordingError
from robotcore.recording.limits import DAMAGE, MAX_RECORD_BYTES, Allowance, format_damage

RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")


class Message(NamedTuple):
    """A message in a channel of the file."""

    channel_id: int
    sequence: int
    """The sequence number of the message in its channel. The first message has 1."""
    data: memoryview


Record = Schema | Channel | Message


@dataclass(frozen=True)
class ChunkLocation:
    """The place, the size and the compression of a chunk's data in the file."""

    offset: int
    """The offset of the packed data in the file, in bytes."""
    length: int
    """The length of the packed data, in bytes."""
    size: int
    """The length of the unpacked data, in bytes."""
    crc: int
    """The CRC-32 of the unpacked data; 0 if the file has no checksum for it."""
    compression: str
    """The name of the compression; empty if the data are not packed."""


class ChunkHeader(NamedTuple):
    """The header of a chunk."""

    begin_ns: int
    """The time of the first message, in nanoseconds."""
    end_ns: int
    """The time of the last message, in nanoseconds."""
    location: ChunkLocation


def unpack(location: ChunkLocation, packed: bytes | memoryview) -> bytes | memoryview:
    """Return the unpacked data of a chunk.

    Raises ValueError or ZstdError if the data are too large, or have another size or checksum than the location.
    The method lz4 is refused, because its library cannot limit the size of its output. A hostile file could fill the
    memory.
    """
    if location.size > MAX_RECORD_BYTES:
        raise ValueError(f"the size of a chunk is {location.size} bytes, above the limit of {MAX_RECORD_BYTES}")
    if location.compression == "zstd":
        packed = _unpack_zstd(packed, location.size)
    elif location.compression:
        raise ValueError(f"a chunk is packed with {location.compression!r} instead of zstd")
    if len(packed) != location.size:
        raise ValueError(f"a chunk has {len(packed)} bytes instead of {location.size}")
    if location.crc and zlib.crc32(packed) != location.crc:
        raise ValueError("the checksum of a chunk is wrong")
    return packed


def _unpack_zstd(packed: bytes | memoryview, size: int) -> bytes:
    """Unpack a Zstandard frame of ``size`` bytes.

    zstandard ignores ``max_output_size`` if the frame's header states a size, so this size is checked first.
    """
    claimed = get_frame_parameters(packed).content_size
    if claimed not in (size, CONTENTSIZE_UNKNOWN):
        raise ValueError(f"a Zstandard frame states {claimed} bytes instead of {size}")
    return ZstdDecompressor().decompress(packed, max_output_size=size)


def read_records(data: bytes | memoryview, allowance: Allowance | None = None) -> Iterator[Record]:
    """Yield the schemas, channels and messages in the unpacked data of a chunk."""
    view, at = memoryview(data), 0
    while at < len(view):
        opcode, length = RECORD.unpack_from(view, at)
        at += RECORD.size
        body = view[at : at + length]
        if len(body) < length:
            raise ValueError("a record is longer than its chunk")
        at += length
        if allowance:
            allowance.take_record()
        if opcode == Opcode.MESSAGE:
            channel, sequence, *_ = _MESSAGE.unpack_from(body)
            yield Message(channel, sequence, body[_MESSAGE.size :])
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            if allowance:
                allowance.take_text(length)
            kind = Schema if opcode == Opcode.SCHEMA else Channel
            yield kind.read(ReadDataStream(BytesIO(body)))


MAGIC = b"\x89MCAP0\r\n"

_INVALID_OPCODE = 0
_CHUNK = struct.Struct("<QQQII")
"""The header of a chunk: first and last message time, unpacked size, checksum, length of the compression's name."""
_LENGTH = struct.Struct("<Q")

CHUNK_HEADER_BYTES = 64
"""A number of bytes that is enough for the header of each chunk that robotcore writes."""


class ChunkedFile:
    """Reads the chunks of an MCAP file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.is_whole = False
        """Whether `chunks` has reached the end of an intact file."""
        self.damage = ""
        """The first damage and its place; empty if there is none. A missing end is not damage."""
        self.allowance = Allowance()

    def chunks(self) -> Iterator[tuple[ChunkLocation, Iterator[Record]]]:
        """Yield each chunk with an iterator of its records, until the end of the file or the first damaged chunk.

        The iterator raises one of the errors in `DAMAGE` if a record is malformed. Raises RecordingError if the file
        cannot be read or is not an MCAP file.
        """
        with _open_regular(self._path) as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise RecordingError(
                    self._path,
                    "the file is not an MCAP file",
                    "Name a file that robotcore has recorded",
                    kind="not-a-recording",
                )
            yield from self._chunks(file)

    def read_again(self, location: ChunkLocation) -> Iterator[Record]:
        """Return the records of a chunk that `chunks` has yielded. Raises RecordingError if the file has changed."""
        try:
            with _open_regular(self._path) as file:
                file.seek(location.offset)
                return read_records(unpack(location, file.read(location.length)))
        except RecordingError:
            raise
        except DAMAGE as error:
            raise RecordingError(
                self._path, "the file has changed since it was opened", "Open it again", kind="recording-changed"
            ) from error

    def _chunks(self, file: BinaryIO) -> Iterator[tuple[ChunkLocation, Iterator[Record]]]:
        size = os.fstat(file.fileno()).st_size
        crc: int | None = zlib.crc32(MAGIC)  # None after a record that is too long to read
        while len(head := file.read(RECORD.size)) == RECORD.size:
            opcode, length = RECORD.unpack(head)
            at = file.tell()
            if length > size - at or opcode == _INVALID_OPCODE:
                if opcode == _INVALID_OPCODE or _has_end_magic(file):
                    self._set_damage(at, "a record has an invalid type or length")
                return
            if opcode == Opcode.DATA_END:
                self._check_checksum(int.from_bytes(file.read(4), "little"), crc, at)
                self.is_whole = not self.damage and _has_end_magic(file)
                return
            body = file.read(length) if length <= MAX_RECORD_BYTES else None
            crc = None if crc is None or body is None else zlib.crc32(body, zlib.crc32(head, crc))
            if opcode in (Opcode.CHUNK, Opcode.MESSAGE_INDEX):
                self.allowance.grow(min(length, MAX_RECORD_BYTES))
            if opcode == Opcode.CHUNK:
                try:
                    location, data = _unpack_chunk(body, at)
                except DAMAGE as error:
                    self.damage = format_damage(at - RECORD.size, error)
                    return
                yield location, read_records(data, self.allowance)
            elif body is None:
                file.seek(length, os.SEEK_CUR)
        if size > len(MAGIC) and _has_end_magic(file):
            self._set_damage(size + RECORD.size, "the record that ends the data is missing")

    def _check_checksum(self, written: int, crc: int | None, at: int) -> None:
        if written and crc not in (None, written):
            self._set_damage(at, "the checksum of the file is wrong")

    def _set_damage(self, at: int, problem: str) -> None:
        self.damage = format_damage(at - RECORD.size, ValueError(problem))


def _unpack_chunk(content: bytes | None, at: int) -> tuple[ChunkLocation, bytes | memoryview]:
    """Return the location of a chunk's data, and the unpacked data.

    content: the chunk; None if it is too long to read.
    at: the offset of the chunk in the file.
    """
    if content is None:
        raise ValueError(f"a chunk has more than {MAX_RECORD_BYTES} bytes")
    location = locate_chunk(content, at).location
    packed = memoryview(content)[location.offset - at :][: location.length]
    return location, unpack(location, packed)


def locate_chunk(content: bytes, at: int) -> ChunkHeader:
    """Return the header of a chunk.

    content: the chunk, or at least its first `CHUNK_HEADER_BYTES` bytes.
    at: the offset of the chunk in the file.
    """
    begin_ns, end_ns, size, crc, name_length = _CHUNK.unpack_from(content)
    name_end = _CHUNK.size + name_length
    (length,) = _LENGTH.unpack_from(content, name_end)
    compression = content[_CHUNK.size : name_end].decode()
    return ChunkHeader(begin_ns, end_ns, ChunkLocation(at + name_end + _LENGTH.size, length, size, crc, compression))


@contextmanager
def _open_regular(path: Path) -> Iterator[BinaryIO]:
    try:
        with open(path, "rb", opener=_open_nonblocking) as file:  # a FIFO without a writer must not block
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise RecordingError(
                    path,
                    "the path is not a regular file",
                    "Name a file that robotcore has recorded",
                    kind="not-a-regular-file",
                )
            yield file
    except OSError as error:
        raise RecordingError(
            path, str(error.strerror), "Name a recording that can be read", kind="recording-unreadable"
        ) from None


def _open_nonblocking(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0))  # Windows lacks both


def _has_end_magic(file: BinaryIO) -> bool:
    file.seek(-len(MAGIC), os.SEEK_END)
    return file.read() == MAGIC
