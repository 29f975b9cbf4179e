"""The records in a chunk of an MCAP file: unpacked within limits, and read one by one.

A file may be hostile: each length in it is only a claim. The format: https://mcap.dev/spec.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from pydantic import ValidationError
from zstandard import CONTENTSIZE_UNKNOWN, ZstdDecompressor, ZstdError, get_frame_parameters

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


def damage_at(offset: int, error: BaseException) -> str:
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
