"""A TCP connection that exchanges messages with a server. Each message is split into packets."""

from __future__ import annotations

import io
import socket
import struct
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from typing import Any

from drivers.vrep.wire.codec import Header, Piece, decode_message, encode_message
from drivers.vrep.wire.errors import NoServerError, ProtocolError, ServerLostError, ServerTimeoutError
from drivers.vrep.wire.requests import Identity
from robotcore.hal.wall_clock import MonotonicClock

RETRY_S = 0.1
_QUICKACK: int | None = getattr(socket, "TCP_QUICKACK", None)
"""The number of a socket option of Linux; None on other systems."""

_BUFFER_BYTES = 1 << 18
_CLIENT_TIME_MASK = 0x03FFFFFF


class MessageSocket:
    """A TCP connection to a server that answers each message with one reply. The first error closes the connection.

    connection: the open socket.
    name: the name of the server in error messages.
    timeout_s: time limit of an exchange, in seconds.

    Only one thread at a time may use it.
    """

    def __init__(self, connection: socket.socket, name: str, timeout_s: float) -> None:
        self._socket, self._name, self._timeout_s = connection, name, timeout_s
        self._clock = MonotonicClock()
        self._incoming = _Incoming(connection)
        self._reader = io.BufferedReader(self._incoming, _BUFFER_BYTES)
        self._assembler = AnswerAssembler()
        self.exchanges = 0
        """The number of replies that the server has sent."""

    @classmethod
    def open(cls, host: str, port: int, timeout_s: float) -> MessageSocket:
        """Connect to a server. Raises NoServerError if no server listens.

        timeout_s: time limit of an exchange, in seconds.
        """
        return cls(_open_socket(host, port, timeout_s), f"the simulator at {host}:{port}", timeout_s)

    def exchange(self, number: int, commands: Iterable[bytes]) -> tuple[Header, list[Piece]]:
        """Send a message, receive the reply, and return its header and the complete answers.

        number: the number of the message.
        commands: the encoded commands.

        The answers are those to commands of earlier messages. The answers to ``commands`` come with a later reply,
        after the main thread of the simulator has executed the commands.
        """
        try:
            header, pieces = decode_message(
                self._exchange_message(encode_message(number, self._client_time_ms(), commands))
            )
        except BaseException:
            self.close()
            raise
        self.exchanges += 1
        return header, [answer for piece in pieces if (answer := self._assembler.add(piece))]

    def close(self) -> None:
        """Disconnect. In a thread that waits for a reply, `exchange` then raises an error.

        This method does not send the command that ends a connection. After this command the server would close the
        connection first, and the server's operating system would block the port for a minute.
        """
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def _exchange_message(self, message: bytes) -> bytes:
        deadline = self._clock.now() + self._timeout_s
        try:
            self._socket.settimeout(self._timeout_s)
            self._socket.sendall(encode_packets(message))
            self._incoming.deadline = deadline
            reply = read_packets(self._read)
        except TimeoutError as error:
            raise self._timeout_error() from error
        except OSError as error:
            raise self._lost_error(error) from error
        if self._incoming.unread:
            raise ProtocolError(f"{self._incoming.unread} bytes follow the end of the reply")
        return reply

    def _read(self, size: int) -> bytes:
        data = self._reader.read(size)
        self._incoming.unread -= len(data)
        return data

    def _client_time_ms(self) -> int:
        return int(self._clock.now() * 1000) & _CLIENT_TIME_MASK

    def _lost_error(self, error: OSError) -> ServerLostError:
        if self.exchanges:
            return ServerLostError(
                f"the connection to {self._name} was lost ({error}). Check whether it was closed or its scene was "
                "stopped, start it, and run again"
            )
        return ServerLostError(
            f"{self._name} accepts the connection and closes it ({error}). A port serves one program at a time: end "
            "the other program, or choose another port",
            kind="port-in-use",
        )

    def _timeout_error(self) -> ServerTimeoutError:
        if self.exchanges:
            return ServerTimeoutError(
                f"{self._name} has not answered for {self._timeout_s:g} s. If it hangs, restart it and run again",
                timeout_s=self._timeout_s,
            )
        return ServerTimeoutError(
            f"{self._name} accepts the connection and sends nothing for {self._timeout_s:g} s. A port serves one "
            "program at a time: end the other program, or choose another port",
            kind="port-in-use",
            timeout_s=self._timeout_s,
        )


def _open_socket(host: str, port: int, timeout_s: float) -> socket.socket:
    try:
        connection = socket.create_connection((host, port), timeout_s)
    except (OSError, UnicodeError) as error:  # an invalid host name
        raise NoServerError(
            f"no server listens at {host}:{port} ({error}). Start the simulator, or name its port with --port: the "
            "default is 19997, or 19999 if a script of a running scene has called simRemoteApi.start(19999)",
            address=f"{host}:{port}",
        ) from error
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection


class _Incoming(io.RawIOBase):
    """The bytes that a socket receives. A read after ``deadline`` raises TimeoutError."""

    def __init__(self, connection: socket.socket) -> None:
        self._socket = connection
        self._clock = MonotonicClock()
        self.deadline = 0.0
        self.unread = 0
        """The number of received bytes that `MessageSocket` has not read."""

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        if (left := self.deadline - self._clock.now()) <= 0:
            raise TimeoutError
        self._socket.settimeout(left)
        if _QUICKACK is not None:
            # A server delays each small packet until the previous one is acknowledged (Nagle's algorithm). Without
            # this option, every second packet of an image would take 40 ms. The system may reset it at any time.
            self._socket.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)
        size = self._socket.recv_into(buffer)
        self.unread += size
        return size


class AnswerAssembler:
    """Joins the pieces of long answers. A piece with another total size than its predecessor begins a new answer."""

    def __init__(self) -> None:
        self._incomplete: dict[Identity, bytearray] = {}

    def add(self, piece: Piece) -> Piece | None:
        """Add a piece. Return the whole answer if this was its last piece, otherwise None."""
        if piece.is_whole:
            return piece
        identity = piece.command, piece.key
        buffer = self._incomplete.get(identity)
        if buffer is None or len(buffer) != piece.total:
            buffer = self._incomplete[identity] = bytearray(piece.total)
        end = piece.offset + len(piece.data)
        buffer[piece.offset : end] = piece.data
        if end < piece.total:
            return None
        return replace(piece, data=memoryview(bytes(self._incomplete.pop(identity))), offset=0)


_PACKET_HEADER = struct.Struct("<HHH")
_BYTE_ORDER = 1
MAX_PACKET_BYTES = 1300
_ZEROMQ = bytes.fromhex("ff 00 00 00 00 00")
"""The first bytes of the greeting of a ZeroMQ server. Source: https://rfc.zeromq.org/spec/23."""
_MAX_PAYLOAD_BYTES = MAX_PACKET_BYTES - _PACKET_HEADER.size


def encode_packets(message: bytes) -> bytes:
    """Encode a message of at least one byte as a sequence of packets.

    >>> encode_packets(b"ab").hex(" ", 2)
    '0100 0200 0000 6162'
    """
    view = memoryview(message)
    payloads = [view[at : at + _MAX_PAYLOAD_BYTES] for at in range(0, len(view), _MAX_PAYLOAD_BYTES)]
    parts: list[bytes | memoryview] = []
    for left, payload in zip(reversed(range(len(payloads))), payloads, strict=True):
        parts += (_PACKET_HEADER.pack(_BYTE_ORDER, len(payload), left), payload)
    return b"".join(parts)


def read_packets(read: Callable[[int], bytes]) -> bytes:
    """Read the packets of one message, and return the message.

    read: reads a number of bytes. It returns fewer bytes at the end of the data.

    Raises ProtocolError if a packet is invalid, and ConnectionResetError if the data ends before the message.

    >>> read_packets(io.BytesIO(encode_packets(b"hello")).read)
    b'hello'
    """
    message, packets_left = bytearray(), -1
    while packets_left:
        header = _read_exactly(read, _PACKET_HEADER.size)
        order, size, next_left = _PACKET_HEADER.unpack(header)
        if order != _BYTE_ORDER or size == 0 or packets_left not in (-1, next_left + 1):
            raise ProtocolError(_describe_header(header))
        message += _read_exactly(read, size)
        packets_left = next_left
    return bytes(message)


def _read_exactly(read: Callable[[int], bytes], size: int) -> bytes:
    data = read(size)
    if len(data) < size:
        raise ConnectionResetError("end of data")
    return data


def _describe_header(header: bytes) -> str:
    if header == _ZEROMQ:
        return "it is the greeting of CoppeliaSim's ZeroMQ remote API (--backend coppeliasim)"
    return f"a packet begins with {header.hex(' ')}"
