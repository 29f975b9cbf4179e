"""What answers of the legacy remote API say: how their bytes are read, and how ours are written.

The layouts are those that the functions of the same names in the maker's extApi.c read. A reader raises struct.error or
ValueError where the bytes do not fit.
"""

from __future__ import annotations

import struct
from binascii import crc_hqx
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from drivers.vrep.wire.errors import GarbledReplyError

Pixels = npt.NDArray[np.uint8]
Vector = tuple[float, ...]


@dataclass(frozen=True)
class Proximity:
    """What a proximity sensor says. Unless ``is_detected``, all the rest is rubbish.

    ``point`` and ``normal`` are in the sensor's frame, in metres; the distance is the norm of the point.
    """

    is_detected: bool
    point: Vector
    handle: int
    normal: Vector


def read_int(data: memoryview) -> int:
    """Return a number of 32 bits."""
    return int(struct.unpack_from("<i", data)[0])


def read_float(data: memoryview) -> float:
    """Return a number of single precision."""
    return float(struct.unpack_from("<f", data)[0])


def read_nothing(data: memoryview) -> None:
    """Whatever data a server sends along with what has no value."""


def floats(count: int, offset: int = 0) -> Callable[[memoryview], Vector]:
    """Return what reads so many numbers, after so many bytes."""
    return lambda data: struct.unpack_from(f"<{count}f", data, offset)


def read_proximity(data: memoryview) -> Proximity:
    """Return what a proximity sensor says."""
    detect, *numbers = struct.unpack_from("<B3fi3f", data)
    return Proximity(detect != 0, tuple(numbers[:3]), numbers[3], tuple(numbers[4:]))


def read_colour(data: memoryview) -> Pixels:
    """Return the image: (height, width, 3), RGB, row 0 at the bottom; read-only."""
    return np.frombuffer(data, np.uint8, offset=8).reshape(*_rows_and_columns(data), 3)


def read_grey(data: memoryview) -> Pixels:
    """Return the image: (height, width), row 0 at the bottom; read-only."""
    return np.frombuffer(data, np.uint8, offset=8).reshape(_rows_and_columns(data))


def read_depth(data: memoryview) -> npt.NDArray[np.float32]:
    """Return the depth: (height, width), 0 at the near and 1 at the far clipping plane, row 0 at the bottom."""
    return np.frombuffer(data, np.dtype("<f4"), offset=8).reshape(_rows_and_columns(data))


def _rows_and_columns(data: memoryview) -> tuple[int, int]:
    width, height = struct.unpack_from("<2i", data)
    if width < 1 or height < 1:
        raise ValueError(f"an image of {width} × {height}")
    return height, width


def read_errors(data: memoryview) -> list[str]:
    """Return messages, oldest first."""
    count = read_int(data)
    return [words.decode("utf-8", "replace") for words in bytes(data[4:]).split(b"\0")[:count]]


def read_ints(data: memoryview) -> list[int]:
    """Return the numbers that follow their count."""
    return list(struct.unpack_from(f"<{max(read_int(data), 0)}i", data, 4))


def pack_floats(*values: float) -> bytes:
    """Return numbers as C's floats, whatever type they are of."""
    return struct.pack(f"<{len(values)}f", *values)


def pack_ints(*values: int) -> bytes:
    """Return numbers as C's ints, whatever type they are of."""
    return struct.pack(f"<{len(values)}i", *values)


def read_text(data: memoryview) -> str:
    """Return a text, which ends where it has a zero."""
    return bytes(data).split(b"\0")[0].decode("utf-8", "replace")


VERSION = 11
_HEADER = struct.Struct("<HBiiiHB")
_COMMAND = struct.Struct("<iiHiiHiBB")
_CRC_BYTES = 2
NUMBER_MASK = 0xFFFF
"""The bits of a command that are its number; those above are its operation mode."""

NOTHING_DONE = -1
"""The message number of a reply that comes before anything asked for since the last one was done."""

_RUNNING, _PAUSED = 1, 2
_FAILED = 1


@dataclass(frozen=True)
class Header:
    """How things are with the server: the last message it has done, its own time, its scene and state."""

    version: int
    message: int
    client_time_ms: int
    server_time_ms: int
    scene: int
    state: int

    @property
    def is_running(self) -> bool:
        """Whether the simulation is not stopped; it may be paused."""
        return bool(self.state & _RUNNING)

    @property
    def is_paused(self) -> bool:
        return bool(self.state & _PAUSED)


@dataclass(frozen=True)
class Piece:
    """What one reply says of one command: all of its data, or ``data`` from ``offset`` on of ``total`` bytes.

    ``key`` tells like commands apart: handles or names. ``time_ms`` is the simulation's time at which it was done.
    """

    command: int
    key: bytes
    mode: int
    time_ms: int
    is_failed: bool
    data: memoryview
    offset: int = 0
    total: int = 0

    @property
    def is_whole(self) -> bool:
        return len(self.data) == self.total


def encode_message(number: int, time_ms: int, commands: Iterable[bytes]) -> bytes:
    """Return the message of that number, sent at ``time_ms`` of the client's own time."""
    header = _HEADER.pack(0, VERSION, number, time_ms, 0, 0, 0)
    rest = b"".join((header[_CRC_BYTES:], *commands))
    return crc_hqx(rest, 0).to_bytes(_CRC_BYTES, "little") + rest


def encode_command(command: int, mode: int, delay: int, key: bytes, data: bytes) -> bytes:
    """Return a command as it stands in a message.

    ``delay`` is the least time in ms between streamed answers, or how many bytes one piece of a split answer has.
    """
    size = _COMMAND.size + len(key) + len(data)
    return _COMMAND.pack(size, size, len(key), 0, command | mode, delay, 0, 0, 0) + key + data


def decode_message(message: bytes) -> tuple[Header, list[Piece]]:
    """Return what a reply says; GarbledReplyError if it is none."""
    if len(message) < _HEADER.size:
        raise GarbledReplyError(f"its header has {len(message)} bytes instead of {_HEADER.size}")
    crc, *fields = _HEADER.unpack_from(message)
    header = Header(*fields)
    if not 1 <= header.version <= VERSION:
        raise GarbledReplyError(f"its version is {header.version}; this client knows 1 to {VERSION}")
    if crc and crc != crc_hqx(memoryview(message)[_CRC_BYTES:], 0):
        raise GarbledReplyError("its check sum is wrong")
    return header, _pieces(memoryview(message)[_HEADER.size :])


def _pieces(rest: memoryview) -> list[Piece]:
    pieces = []
    while rest:
        piece, size = _piece(rest)
        pieces.append(piece)
        rest = rest[size:]
    return pieces


def _piece(rest: memoryview) -> tuple[Piece, int]:
    if len(rest) < _COMMAND.size:
        raise GarbledReplyError(f"{len(rest)} bytes stand where a command should")
    size, full, key_size, offset, command, _, time_ms, status, _ = _COMMAND.unpack_from(rest)
    first = _COMMAND.size + key_size
    if not first <= size <= len(rest) or offset < 0 or full < size + offset:
        raise GarbledReplyError(f"a command says that it has {size} of {full} bytes, where {len(rest)} are left")
    number, mode = command & NUMBER_MASK, command & ~NUMBER_MASK
    key, data = bytes(rest[_COMMAND.size : first]), rest[first:size]
    return Piece(number, key, mode, time_ms, bool(status & _FAILED), data, offset, full - first), size


_PACKET_HEADER = struct.Struct("<HHH")
_BYTE_ORDER = 1
MAX_PACKET_BYTES = 1300
_ZEROMQ = bytes.fromhex("ff 00 00 00 00 00")
"""With which a server of ZeroMQ greets, https://rfc.zeromq.org/spec/23."""
_MAX_PAYLOAD_BYTES = MAX_PACKET_BYTES - _PACKET_HEADER.size


def encode_packets(message: bytes) -> bytes:
    """Return a message, at least one byte, as the packets that carry it, one after the other."""
    view = memoryview(message)
    payloads = [view[at : at + _MAX_PAYLOAD_BYTES] for at in range(0, len(view), _MAX_PAYLOAD_BYTES)]
    parts: list[bytes | memoryview] = []
    for left, payload in zip(reversed(range(len(payloads))), payloads, strict=True):
        parts += (_PACKET_HEADER.pack(_BYTE_ORDER, len(payload), left), payload)
    return b"".join(parts)


class Unpacker:
    """Puts one message together from what is received, however it is cut."""

    def __init__(self) -> None:
        self._received = bytearray()
        self._message = bytearray()
        self._left: int | None = None

    def feed(self, chunk: bytes | memoryview) -> bytes | None:
        """Take what has been received; return the message when it is whole.

        Bytes after its end raise GarbledReplyError: a server speaks only when it was asked.
        """
        self._received += chunk
        taken = 0
        while self._left != 0 and (payload := self._packet_at(taken)):
            self._message += memoryview(self._received)[payload]
            taken = payload.stop
        del self._received[:taken]
        if self._left != 0:
            return None
        if self._received:
            raise GarbledReplyError(f"{len(self._received)} bytes follow its end")
        return bytes(self._message)

    def _packet_at(self, start: int) -> slice | None:
        """Return where the payload of the packet is that begins at ``start``, if all of it is there."""
        first = start + _PACKET_HEADER.size
        if len(self._received) < first:
            return None
        order, size, left = _PACKET_HEADER.unpack_from(self._received, start)
        if order != _BYTE_ORDER or size == 0 or (self._left is not None and left != self._left - 1):
            raise GarbledReplyError(_describe_header(bytes(self._received[start:first])))
        if len(self._received) < first + size:
            return None
        self._left = left
        return slice(first, first + size)


def _describe_header(header: bytes) -> str:
    if header == _ZEROMQ:
        return "it greets as CoppeliaSim's ZeroMQ remote API does, which is --backend coppeliasim"
    return f"a packet begins with {header.hex(' ')}"
