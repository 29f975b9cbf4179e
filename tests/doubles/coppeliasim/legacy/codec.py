"""The commands, operation modes and messages of the legacy remote API.

The source of the numbers is ``simConst.h`` of the simulator's maker, version 11 of the remote API. Only the numbers in
use are listed.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum


class Code(IntEnum):
    """The number of a command, without its operation mode.

    The first digit is the form of the command's key: nothing, a handle, two numbers, or a name.
    """

    SYNCHRONOUS_ENABLE = 0x0001
    SYNCHRONOUS_DISABLE = 0x0002
    SYNCHRONOUS_NEXT = 0x0003
    GET_LAST_ERRORS = 0x0004
    KILL_CONNECTION = 0x000A

    GET_JOINT_POSITION = 0x1001
    GET_VISION_SENSOR_IMAGE_BW = 0x1003
    GET_VISION_SENSOR_IMAGE_RGB = 0x1004
    SET_VISION_SENSOR_IMAGE_BW = 0x1005
    SET_VISION_SENSOR_IMAGE_RGB = 0x1006
    START_PAUSE_STOP_SIMULATION = 0x1007
    SET_JOINT_TARGET_VELOCITY = 0x1008
    READ_PROXIMITY_SENSOR = 0x1009
    READ_VISION_SENSOR = 0x1011
    GET_INTEGER_PARAMETER = 0x1021
    GET_FLOATING_PARAMETER = 0x1023
    SET_FLOATING_PARAMETER = 0x1024

    GET_OBJECT_FLOAT_PARAMETER = 0x2007
    GET_OBJECT_INT_PARAMETER = 0x2008
    GET_OBJECT_GROUP_DATA = 0x200C
    GET_OBJECT_ORIENTATION = 0x200D
    GET_OBJECT_POSITION = 0x200E

    GET_OBJECT_HANDLE = 0x3001
    GET_FLOAT_SIGNAL = 0x3010
    GET_INTEGER_SIGNAL = 0x3011
    SET_FLOAT_SIGNAL = 0x3013
    SET_INTEGER_SIGNAL = 0x3014


class Mode(IntEnum):
    """An operation mode, which is added to a command's number. ``buffer`` and ``remove`` are never sent."""

    ONESHOT = 0x00000
    BLOCKING = 0x10000
    STREAMING = 0x20000
    DISCONTINUE = 0x50000


CODE_MASK = 0xFFFF
VERSION = 11
PACKET = struct.Struct("<HHH")
HEADER = struct.Struct("<HBiiiHB")
COMMAND = struct.Struct("<iiHiiHiBB")

PACKET_SIZE = 1300
"""The maximum size of a packet in bytes."""


class ProtocolError(Exception):
    """The received bytes are not a message of a legacy client, or the double does not support it."""


@dataclass(frozen=True)
class Header:
    """The header of a message. A client sends arbitrary bytes in the fields that the server fills."""

    message: int
    client_ms: int
    server_ms: int = 0
    scene: int = 0
    state: int = 0


@dataclass(frozen=True)
class Command:
    """A command, or the answer to a command.

    ``delay_ms`` is the minimum time between two answers of a stream. In an answer, bit 0 of ``status`` is an error.
    In a command, this bit keeps an older command with the same identity.
    """

    code: int
    mode: int
    identity: bytes = b""
    data: bytes = b""
    delay_ms: int = 0
    sim_ms: int = 0
    status: int = 0


def pack(header: Header, commands: Iterable[Command] = ()) -> bytes:
    """Encode a message. The result is not split into packets."""
    first = HEADER.pack(0, VERSION, header.message, header.client_ms, header.server_ms, header.scene, header.state)
    return b"".join((first, *map(_pack_command, commands)))


def _pack_command(command: Command) -> bytes:
    size = COMMAND.size + len(command.identity) + len(command.data)
    number = command.code | command.mode
    fields = (len(command.identity), 0, number, command.delay_ms, command.sim_ms, command.status, 0)
    return COMMAND.pack(size, size, *fields) + command.identity + command.data


def unpack(message: bytes) -> tuple[Header, list[Command]]:
    """Decode a message to its header and commands; raises ProtocolError if its sizes do not fit its length."""
    try:
        _, version, *rest = HEADER.unpack_from(message)
        if version != VERSION:
            raise ProtocolError(f"a message of version {version}")
        commands, offset = [], HEADER.size
        while offset < len(message):
            command, offset = _unpack_command(message, offset)
            commands.append(command)
    except struct.error as error:
        raise ProtocolError(f"a cut message of {len(message)} bytes") from error
    return Header(*rest), commands


def _unpack_command(message: bytes, offset: int) -> tuple[Command, int]:
    size, whole, identity_size, _, number, delay_ms, sim_ms, status, _ = COMMAND.unpack_from(message, offset)
    start, end = offset + COMMAND.size, offset + size
    if size != whole or not start + identity_size <= end <= len(message):  # a split mode has another whole size
        raise ProtocolError(f"a command of {size} of {whole} bytes in a message of {len(message)} bytes")
    identity, data = message[start : start + identity_size], message[start + identity_size : end]
    return Command(number & CODE_MASK, number & ~CODE_MASK, identity, data, delay_ms, sim_ms, status), end


def encode_packets(message: bytes) -> bytes:
    """Encode a message as packets of at most `PACKET_SIZE` bytes."""
    room = PACKET_SIZE - PACKET.size
    pieces = [message[start : start + room] for start in range(0, len(message), room)]
    left = range(len(pieces) - 1, -1, -1)
    return b"".join(PACKET.pack(1, len(piece), more) + piece for piece, more in zip(pieces, left, strict=True))


def read_message(receive: Callable[[int], bytes]) -> bytes:
    """Read the packets of the next message, and return the message. ``receive`` reads a given number of bytes."""
    pieces, left = [], 1
    while left:
        endian, size, left = PACKET.unpack(receive(PACKET.size))
        if endian != 1:
            raise ProtocolError(f"a packet begins with {endian}: a big-endian client, which the double does not serve")
        pieces.append(receive(size))
    return b"".join(pieces)
