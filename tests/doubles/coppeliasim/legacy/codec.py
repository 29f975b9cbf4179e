"""The commands, operation modes and messages of the legacy remote API.

The source of the numbers is ``simConst.h`` of the simulator's maker, version 11 of the remote API. Only the numbers in
use are listed.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import IntEnum

NULL, FOUR_BYTES, EIGHT_BYTES, ONE_STRING = 0x0000, 0x1000, 0x2000, 0x3000
"""The form of a command's key: nothing, a handle, two numbers, or a name."""


class Code(IntEnum):
    """The number of a command, without its operation mode."""

    SYNCHRONOUS_ENABLE = NULL + 1
    SYNCHRONOUS_DISABLE = NULL + 2
    SYNCHRONOUS_NEXT = NULL + 3
    GET_LAST_ERRORS = NULL + 4
    KILL_CONNECTION = NULL + 10

    GET_JOINT_POSITION = FOUR_BYTES + 1
    SET_JOINT_POSITION = FOUR_BYTES + 2
    GET_VISION_SENSOR_IMAGE_BW = FOUR_BYTES + 3
    GET_VISION_SENSOR_IMAGE_RGB = FOUR_BYTES + 4
    SET_VISION_SENSOR_IMAGE_BW = FOUR_BYTES + 5
    SET_VISION_SENSOR_IMAGE_RGB = FOUR_BYTES + 6
    START_PAUSE_STOP_SIMULATION = FOUR_BYTES + 7
    SET_JOINT_TARGET_VELOCITY = FOUR_BYTES + 8
    READ_PROXIMITY_SENSOR = FOUR_BYTES + 9
    READ_VISION_SENSOR = FOUR_BYTES + 17
    GET_OBJECT_PARENT = FOUR_BYTES + 18
    SET_OBJECT_ORIENTATION = FOUR_BYTES + 26
    SET_OBJECT_POSITION = FOUR_BYTES + 27
    GET_INTEGER_PARAMETER = FOUR_BYTES + 33
    GET_FLOATING_PARAMETER = FOUR_BYTES + 35
    SET_FLOATING_PARAMETER = FOUR_BYTES + 36
    GET_OBJECTS = FOUR_BYTES + 42
    GET_OBJECT_VELOCITY = FOUR_BYTES + 54

    GET_OBJECT_FLOAT_PARAMETER = EIGHT_BYTES + 7
    GET_OBJECT_INT_PARAMETER = EIGHT_BYTES + 8
    GET_OBJECT_CHILD = EIGHT_BYTES + 11
    GET_OBJECT_GROUP_DATA = EIGHT_BYTES + 12
    GET_OBJECT_ORIENTATION = EIGHT_BYTES + 13
    GET_OBJECT_POSITION = EIGHT_BYTES + 14

    GET_OBJECT_HANDLE = ONE_STRING + 1
    ADD_STATUSBAR_MESSAGE = ONE_STRING + 8
    CLEAR_FLOAT_SIGNAL = ONE_STRING + 13
    CLEAR_INTEGER_SIGNAL = ONE_STRING + 14
    GET_FLOAT_SIGNAL = ONE_STRING + 16
    GET_INTEGER_SIGNAL = ONE_STRING + 17
    SET_FLOAT_SIGNAL = ONE_STRING + 19
    SET_INTEGER_SIGNAL = ONE_STRING + 20


class Mode(IntEnum):
    """An operation mode, which is added to a command's number. ``buffer`` and ``remove`` are never sent."""

    ONESHOT = 0x00000
    BLOCKING = 0x10000
    STREAMING = 0x20000
    ONESHOT_SPLIT = 0x30000
    STREAMING_SPLIT = 0x40000
    DISCONTINUE = 0x50000


CODE_MASK = 0xFFFF


VERSION = 11
PACKET = struct.Struct("<HHH")
HEADER = struct.Struct("<HBiiiHB")
COMMAND = struct.Struct("<iiHiiHiBB")

PACKET_SIZE = 1300
"""The default maximum size of a packet in bytes."""


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
    return b"".join((first, *(_command(each) for each in commands)))


def _command(command: Command) -> bytes:
    size = COMMAND.size + len(command.identity) + len(command.data)
    number = command.code | command.mode
    sub = COMMAND.pack(
        size, size, len(command.identity), 0, number, command.delay_ms, command.sim_ms, command.status, 0
    )
    return sub + command.identity + command.data


def unpack(message: bytes) -> tuple[Header, list[Command]]:
    """Decode a message to its header and commands; raises ProtocolError if its sizes do not fit its length."""
    if len(message) < HEADER.size:
        raise ProtocolError(f"a message of {len(message)} bytes has no room for a header")
    _, version, *rest = HEADER.unpack_from(message)
    if version != VERSION:
        raise ProtocolError(f"a message of version {version}; got {VERSION} from every client of record")
    commands, offset = [], HEADER.size
    while offset < len(message):
        command, offset = _unpack_command(message, offset)
        commands.append(command)
    return Header(*rest), commands


def _unpack_command(message: bytes, offset: int) -> tuple[Command, int]:
    if offset + COMMAND.size > len(message):
        raise ProtocolError(f"{len(message) - offset} bytes are left over, too few for a command")
    size, whole, identified, _, number, delay_ms, sim_ms, status, _ = COMMAND.unpack_from(message, offset)
    if size != whole:
        raise ProtocolError(f"{size} of {whole} bytes of a command: split modes are not served")
    start, end = offset + COMMAND.size, offset + size
    if not start + identified <= end <= len(message):
        raise ProtocolError(f"a command of {size} bytes, {identified} of them its identity, does not fit the message")
    mode = number & ~CODE_MASK
    identity, data = message[start : start + identified], message[start + identified : end]
    return Command(number & CODE_MASK, mode, identity, data, delay_ms, sim_ms, status), end


def encode_packets(message: bytes, packet_size: int = PACKET_SIZE) -> bytes:
    """Encode a message as packets of at most ``packet_size`` bytes."""
    room = packet_size - PACKET.size
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


def is_repeated(mode: int) -> bool:
    """Return whether the server keeps a command of this mode after its execution."""
    return mode == Mode.STREAMING
