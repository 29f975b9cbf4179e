"""Read the chunks and records of an MCAP file, with limits for hostile files.

Each length in a file is only a claim. The format: https://mcap.dev/spec.
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
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from pydantic import ValidationError
from zstandard import CONTENTSIZE_UNKNOWN, ZstdDecompressor, ZstdError, get_frame_parameters

from robotcore.errors import RecordingError
from robotcore.text import escape

DAMAGE = (
    *(McapError, ZstdError, struct.error, ValueError, LookupError, OverflowError),
    *(RecursionError, MemoryError),
)
"""The errors that malformed bytes can raise while a chunk is read."""

MAX_RECORD_BYTES = 2**26
"""The most bytes of one record, packed or unpacked.

A chunk of robotcore has 1 MiB and one message more: a picture of at most 60 MB.
"""

_PROBLEM_LENGTH = 160

RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")


class Message(NamedTuple):
    """A message of a channel; ``sequence`` counts the messages of the channel from one."""

    channel_id: int
    sequence: int
    data: memoryview


Record = Schema | Channel | Message


@dataclass(frozen=True)
class ChunkLocation:
    """The place of a chunk's packed data in the file; ``size`` and ``crc`` are those of the unpacked data."""

    offset: int
    length: int
    size: int
    crc: int
    compression: str


class Allowance:
    """How many records, how much text and how many JSON values may be read, in proportion to the bytes read so far.

    Raises ValueError when one runs out. A recording of robotcore has an index entry of 16 bytes for each record. With
    its index, a run that stands still has 4 bytes of text and 0.3 values for each byte. Each limit leaves room for
    about three times as much.
    """

    MESSAGE_TEXT = 2**22

    def __init__(self) -> None:
        self._records, self._text, self._values = 2**16, 2**22, 2**16

    def grow(self, read_bytes: int) -> None:
        """Allow more for bytes that were read."""
        self._records += read_bytes // 8
        self._text += 12 * read_bytes
        self._values += read_bytes

    def take_record(self) -> None:
        """Count a record."""
        self._records -= 1
        if self._records < 0:
            raise ValueError("more records than a file of this size can have")

    def take_text(self, length: int) -> None:
        """Count text that becomes objects in memory, in bytes."""
        self._text -= length
        if self._text < 0 or length > self.MESSAGE_TEXT:
            raise ValueError("more text than a file of this size can have")

    def take_values(self, json_text: bytes) -> None:
        """Count the values of a JSON text: never fewer than it has, as its separators and brackets tell."""
        self._values -= sum(map(json_text.count, (b",", b"[", b"{")))
        if self._values < 0:
            raise ValueError("more values than a file of this size can have")


class Lz4Error(ValueError):
    """A chunk is packed with lz4. The lz4 library cannot limit what it unpacks, and robotcore never writes lz4."""


def format_damage(offset: int, error: BaseException) -> str:
    """Return where a file is damaged and how, in a line."""
    problem = str(error)
    if isinstance(error, ValidationError):
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        problem = ": ".join(filter(None, (".".join(map(str, first["loc"])), first["msg"])))
    elif isinstance(error, MemoryError):
        problem = "there is not enough memory for it"
    elif not problem or isinstance(error, LookupError):
        problem = f"{type(error).__name__} {problem}".strip()
    return f"byte {offset}, {escape(problem[:_PROBLEM_LENGTH])}"


def unpack(place: ChunkLocation, packed: bytes | memoryview) -> bytes | memoryview:
    """Return the content of a chunk; ValueError or ZstdError if it is too large or not what the chunk claims."""
    if place.size > MAX_RECORD_BYTES:
        raise ValueError(f"a chunk claims {place.size} bytes, more than {MAX_RECORD_BYTES}")
    if place.compression == "zstd":
        packed = _unpack_zstd(packed, place.size)
    elif place.compression == "lz4":
        raise Lz4Error("it is packed with lz4")
    elif place.compression:
        raise ValueError(f"a chunk is packed with {place.compression!r}")
    if len(packed) != place.size:
        raise ValueError(f"a chunk has {len(packed)} bytes, and claims {place.size}")
    if place.crc and zlib.crc32(packed) != place.crc:
        raise ValueError("the checksum of a chunk is wrong")
    return packed


def _unpack_zstd(packed: bytes | memoryview, size: int) -> bytes:
    """Return what a frame holds. The library obeys the size in the frame before the one that it is given."""
    claimed = get_frame_parameters(packed).content_size
    if claimed not in (size, CONTENTSIZE_UNKNOWN):
        raise ValueError(f"a frame claims {claimed} bytes in a chunk that claims {size}")
    return ZstdDecompressor().decompress(packed, max_output_size=size)


def read_records(data: bytes | memoryview, allowance: Allowance | None = None) -> Iterator[Record]:
    """Yield what is in a chunk; other kinds of records are passed over."""
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
                raise RecordingError(
                    self._path, "it is no MCAP file", "Name one that robotcore has recorded", kind="not-a-recording"
                )
            yield from self._chunks(file)

    def read_again(self, place: ChunkLocation) -> Iterator[Record]:
        """Return the records of a chunk. Raises RecordingError if the file has changed."""
        try:
            with _open_regular(self._path) as file:
                file.seek(place.offset)
                return read_records(unpack(place, file.read(place.length)))
        except RecordingError:
            raise
        except DAMAGE as error:
            raise RecordingError(
                self._path, "it has changed since it was opened", "Open it again", kind="recording-changed"
            ) from error

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
            raise RecordingError(self._path, "it is packed with lz4", remedy, kind="recording-compression") from error
        except DAMAGE as error:
            self.damage = format_damage(at - RECORD.size, error)
            return None

    def _set_damage(self, at: int, problem: str) -> None:
        self.damage = format_damage(at - RECORD.size, ValueError(problem))

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
                raise RecordingError(
                    path, "it is no regular file", "Name one that robotcore has recorded", kind="not-a-regular-file"
                )
            yield file
    except OSError as error:
        raise RecordingError(
            path, str(error.strerror), "Name a recording that can be read", kind="recording-unreadable"
        ) from error


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
