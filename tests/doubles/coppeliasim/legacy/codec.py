"""Messages of the legacy remote API as bytes: packets on a line, one header, any number of commands.

The layout is the maker's (``simConst.h`` and ``extApi.c`` of the remote API, version 11), little-endian:

    packet     word 1 | word payload's size | word packets still to come | payload
    header     word crc | byte version | int message | int client's time | int server's time | word scene | byte state
    command    int size | int whole size | word identity's size | int shift | int number and mode | word delay or split
               | int simulation time | byte status | byte unused | identity | data

Times are in milliseconds. The CRC is zero both ways and nobody checks it: the maker's plug-in and client gave it up as
a bottleneck. A command's identity is what it is told apart by (a handle, two numbers, a name); a reply repeats it.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from tests.doubles.coppeliasim.legacy.codes import CODE_MASK, Mode

VERSION = 11
PACKET = struct.Struct("<HHH")
HEADER = struct.Struct("<HBiiiHB")
COMMAND = struct.Struct("<iiHiiHiBB")

PACKET_SIZE = 1300
"""Bytes of a packet, at most: what a service has unless it is started with another."""


class ProtocolError(Exception):
    """What came is no message of a client of the legacy remote API, or is one that the double does not serve."""


@dataclass(frozen=True)
class Header:
    """What comes before the commands; a client leaves the server's part open, whatever is in its memory goes out."""

    message: int
    client_ms: int
    server_ms: int = 0
    scene: int = 0
    state: int = 0


@dataclass(frozen=True)
class Command:
    """One command, or the reply to one. ``delay_ms`` is how seldom a stream is wanted; bit 0 of ``status`` is an error.

    From a client, bit 0 of ``status`` asks to keep an older command of the same identity beside this one.
    """

    code: int
    mode: int
    identity: bytes = b""
    data: bytes = b""
    delay_ms: int = 0
    sim_ms: int = 0
    status: int = 0


def pack(header: Header, commands: Iterable[Command] = ()) -> bytes:
    """Return a message without its packets."""
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
    """Return the header and the commands; ProtocolError where the sizes in it do not fit its length."""
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


def packed_up(message: bytes, packet_size: int = PACKET_SIZE) -> bytes:
    """Return a message in packets of at most ``packet_size`` bytes each, ready for the line."""
    room = packet_size - PACKET.size
    pieces = [message[start : start + room] for start in range(0, len(message), room)]
    left = range(len(pieces) - 1, -1, -1)
    return b"".join(PACKET.pack(1, len(piece), more) + piece for piece, more in zip(pieces, left, strict=True))


def read_message(receive: Callable[[int], bytes]) -> bytes:
    """Return the next message, put together from its packets; ``receive`` returns exactly so many bytes."""
    pieces, left = [], 1
    while left:
        endian, size, left = PACKET.unpack(receive(PACKET.size))
        if endian != 1:
            raise ProtocolError(f"a packet begins with {endian}: a big-endian client, which the double does not serve")
        pieces.append(receive(size))
    return b"".join(pieces)


def is_kept(mode: int) -> bool:
    """Return whether a command of this mode stays with the server after it was executed."""
    return mode == Mode.STREAMING
