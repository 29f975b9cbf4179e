"""Messages on the line: each is cut into packets that say how many are still to come.

A packet is a header of three 16-bit words (1, by which the other side sees our byte order; how many bytes follow; how
many packets are left) and that many bytes. The format is that of `_sendSimplePacket_socket` and
`_receiveSimplePacket_socket` in the maker's extApi.c, where a packet has 1300 bytes at most. A server converts to the
byte order of its client: here it is little-endian throughout.
"""

from __future__ import annotations

import struct

from drivers.vrep.wire.errors import GarbledReplyError

_HEADER = struct.Struct("<HHH")
_BYTE_ORDER = 1
MAX_PACKET_BYTES = 1300
_ZEROMQ = bytes.fromhex("ff 00 00 00 00 00")
"""With which a server of ZeroMQ greets, https://rfc.zeromq.org/spec/23."""
_MAX_PAYLOAD_BYTES = MAX_PACKET_BYTES - _HEADER.size


def packed(message: bytes) -> bytes:
    """Return a message, at least one byte, as the packets that carry it, one after the other."""
    view = memoryview(message)
    payloads = [view[at : at + _MAX_PAYLOAD_BYTES] for at in range(0, len(view), _MAX_PAYLOAD_BYTES)]
    parts: list[bytes | memoryview] = []
    for left, payload in zip(reversed(range(len(payloads))), payloads, strict=True):
        parts += (_HEADER.pack(_BYTE_ORDER, len(payload), left), payload)
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
        first = start + _HEADER.size
        if len(self._received) < first:
            return None
        order, size, left = _HEADER.unpack_from(self._received, start)
        if order != _BYTE_ORDER or size == 0 or (self._left is not None and left != self._left - 1):
            raise GarbledReplyError(_fault(bytes(self._received[start:first])))
        if len(self._received) < first + size:
            return None
        self._left = left
        return slice(first, first + size)


def _fault(header: bytes) -> str:
    if header == _ZEROMQ:
        return "it greets as CoppeliaSim's ZeroMQ remote API does, which is --backend coppeliasim"
    return f"a packet begins with {header.hex(' ')}"
