"""Encode and decode values and messages of the legacy remote API.

The source of the values' layouts is extApi.c of the simulator's maker. Each ``read_…`` function decodes a value. It
raises struct.error or ValueError if the bytes are invalid.

A message is a header, followed by commands with their data. The source of its layout is simConst.h of the simulator's
maker, at ``simx_headeroffset_…`` and ``simx_cmdheaderoffset_…``. Recorded sessions of protocol version 11 confirm the
layout. Protocol version 9 (V-REP 3.2) has the same layout.

The check sum is CRC-16/XMODEM over all bytes after the check sum. Early servers require and send a check sum. Later
servers ignore it, and send zero. So this module always sends a check sum, and ignores a received zero.
"""

from __future__ import annotations

import struct
from binascii import crc_hqx
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from drivers.vrep.wire.errors import ProtocolError

Pixels = npt.NDArray[np.uint8]
Vector = tuple[float, ...]


@dataclass(frozen=True)
class Proximity:
    """The reading of a proximity sensor."""

    is_detected: bool
    """Whether the sensor detects an object. If False, the other values are invalid."""
    point: Vector
    """The detected point in the sensor's frame, in metres. Its norm is the distance."""
    handle: int
    """The handle of the detected object."""
    normal: Vector
    """The normal of the detected surface in the sensor's frame."""


def read_int(data: memoryview) -> int:
    """Decode an integer of 32 bits."""
    return int(struct.unpack_from("<i", data)[0])


def read_float(data: memoryview) -> float:
    """Decode a float of 32 bits."""
    return float(struct.unpack_from("<f", data)[0])


def read_nothing(data: memoryview) -> None:
    """Ignore the data of an answer that has no value."""


def floats_reader(count: int) -> Callable[[memoryview], list[float]]:
    """Return a function that decodes a list of ``count`` floats."""

    def read_floats(data: memoryview) -> list[float]:
        return list(struct.unpack_from(f"<{count}f", data))

    return read_floats


def read_proximity(data: memoryview) -> Proximity:
    """Decode the reading of a proximity sensor."""
    detect, *numbers = struct.unpack_from("<B3fi3f", data)
    return Proximity(detect != 0, tuple(numbers[:3]), numbers[3], tuple(numbers[4:]))


def read_colour(data: memoryview) -> Pixels:
    """Decode a colour picture of shape (height, width, 3): RGB, the lowest row first. The result is read-only."""
    return np.frombuffer(data, np.uint8, offset=8).reshape(*_read_shape(data), 3)


def read_grey(data: memoryview) -> Pixels:
    """Decode a grey picture of shape (height, width), the lowest row first. The result is read-only."""
    return np.frombuffer(data, np.uint8, offset=8).reshape(_read_shape(data))


def read_depth(data: memoryview) -> npt.NDArray[np.float32]:
    """Decode a depth picture of shape (height, width), the lowest row first.

    A depth of 0 is at the near clipping plane, and 1 at the far clipping plane.
    """
    return np.frombuffer(data, np.dtype("<f4"), offset=8).reshape(_read_shape(data))


def _read_shape(data: memoryview) -> tuple[int, int]:
    width, height = struct.unpack_from("<2i", data)
    if width < 1 or height < 1:
        raise ValueError(f"a picture has no pixels: {width} × {height}")
    return height, width


def read_errors(data: memoryview) -> list[str]:
    """Decode error messages. The oldest is the first."""
    count = read_int(data)
    return [text.decode("utf-8", "replace") for text in bytes(data[4:]).split(b"\0")[:count]]


def read_ints(data: memoryview) -> list[int]:
    """Decode a list of integers. The data begins with their number."""
    return list(struct.unpack_from(f"<{max(read_int(data), 0)}i", data, 4))


class Group(NamedTuple):
    """The data of a group of objects: the handle of each object, and either an integer or a text for each object."""

    handles: tuple[int, ...]
    numbers: tuple[int, ...]
    texts: tuple[str, ...]


def read_group(data: memoryview) -> Group:
    """Decode the data of a group of objects: four counts, the handles, integers, ignored floats, and texts."""
    handles, numbers, floats, texts = struct.unpack_from("<4i", data)
    if min(handles, numbers, floats, texts) < 0:
        raise ValueError("a negative count")
    whole = struct.unpack_from(f"<{handles + numbers}i", data, 16)
    rest = bytes(data[16 + 4 * (handles + numbers + floats) :])
    decoded = tuple(part.decode("utf-8", "replace") for part in rest.split(b"\0")[:texts])
    return Group(whole[:handles], whole[handles:], decoded)


def pack_floats(*values: float) -> bytes:
    """Encode numbers of any type as 32-bit floats."""
    return struct.pack(f"<{len(values)}f", *values)


def pack_ints(*values: int) -> bytes:
    """Encode numbers of any type as 32-bit integers."""
    return struct.pack(f"<{len(values)}i", *values)


def pack_text(text: str | bytes) -> bytes:
    """Encode a text, which ends at its first zero byte."""
    raw = text.encode() if isinstance(text, str) else bytes(text)
    return raw.split(b"\0")[0] + b"\0"


def read_text(data: memoryview) -> str:
    """Decode a text, which ends at the first zero byte."""
    return bytes(data).split(b"\0")[0].decode("utf-8", "replace")


VERSION = 11
_HEADER = struct.Struct("<HBiiiHB")
_COMMAND = struct.Struct("<iiHiiHiBB")
_CRC_BYTES = 2
NUMBER_MASK = 0xFFFF
"""The bits that hold the number of a command. The higher bits of the same field hold the operation mode."""

NOTHING_DONE = -1
"""`Header.message` of a reply, if the server has executed no message since its previous reply."""

_RUNNING, _PAUSED = 1, 2
_FAILED = 1


@dataclass(frozen=True)
class Header:
    """The header of a reply, which reports the state of the server."""

    version: int
    message: int
    """The number of the newest message whose commands the server has executed."""
    client_time_ms: int
    server_time_ms: int
    scene: int
    state: int
    """The state of the simulation. Bit 0 is set while it runs or is paused, and bit 1 while it is paused."""

    @property
    def is_running(self) -> bool:
        """Whether the simulation runs or is paused."""
        return bool(self.state & _RUNNING)

    @property
    def is_paused(self) -> bool:
        return bool(self.state & _PAUSED)


@dataclass(frozen=True)
class Piece:
    """The answer to one command, or one piece of a long answer."""

    command: int
    """The number of the command."""
    key: bytes
    """The handles or names of the objects that the command is about."""
    mode: int
    """The operation mode of the command."""
    time_ms: int
    """The simulation's time at which the server executed the command."""
    is_failed: bool
    data: memoryview
    offset: int = 0
    """The position of ``data`` in the data of the whole answer, in bytes."""
    total: int = 0
    """The size of the data of the whole answer, in bytes."""

    @property
    def is_whole(self) -> bool:
        return len(self.data) == self.total


def encode_message(number: int, time_ms: int, commands: Iterable[bytes]) -> bytes:
    """Encode a message.

    number: the number of the message.
    time_ms: the time of the client's clock.
    commands: the encoded commands.
    """
    header = _HEADER.pack(0, VERSION, number, time_ms, 0, 0, 0)
    rest = b"".join((header[_CRC_BYTES:], *commands))
    return crc_hqx(rest, 0).to_bytes(_CRC_BYTES, "little") + rest


def encode_command(command: int, mode: int, delay: int, key: bytes, data: bytes) -> bytes:
    """Encode a command.

    command: the number of the command.
    mode: the operation mode.
    delay: for a streaming mode, the minimum time between two answers in ms. For a split mode, the size of one piece of
        the answer in bytes.
    key: the handles or names of the objects that the command is about.
    data: the arguments of the command.
    """
    size = _COMMAND.size + len(key) + len(data)
    return _COMMAND.pack(size, size, len(key), 0, command | mode, delay, 0, 0, 0) + key + data


def decode_message(message: bytes) -> tuple[Header, list[Piece]]:
    """Decode a reply, and return its header and its pieces of answers. Raises ProtocolError if it is invalid."""
    if len(message) < _HEADER.size:
        raise ProtocolError(f"its header has {len(message)} bytes instead of {_HEADER.size}")
    crc, *fields = _HEADER.unpack_from(message)
    header = Header(*fields)
    if not 1 <= header.version <= VERSION:
        raise ProtocolError(f"its version is {header.version}; this client supports 1 to {VERSION}")
    if crc and crc != crc_hqx(memoryview(message)[_CRC_BYTES:], 0):
        raise ProtocolError("its check sum is wrong")
    return header, _decode_pieces(memoryview(message)[_HEADER.size :])


def _decode_pieces(rest: memoryview) -> list[Piece]:
    pieces = []
    while rest:
        piece, size = _decode_piece(rest)
        pieces.append(piece)
        rest = rest[size:]
    return pieces


def _decode_piece(rest: memoryview) -> tuple[Piece, int]:
    if len(rest) < _COMMAND.size:
        raise ProtocolError(f"its last {len(rest)} bytes are too few for a command")
    size, full, key_size, offset, command, _, time_ms, status, _ = _COMMAND.unpack_from(rest)
    first = _COMMAND.size + key_size
    if not first <= size <= len(rest) or offset < 0 or full < size + offset:
        raise ProtocolError(f"a command of {size} bytes (whole answer: {full}) does not fit its last {len(rest)} bytes")
    number, mode = command & NUMBER_MASK, command & ~NUMBER_MASK
    key, data = bytes(rest[_COMMAND.size : first]), rest[first:size]
    return Piece(number, key, mode, time_ms, bool(status & _FAILED), data, offset, full - first), size
