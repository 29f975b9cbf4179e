"""A TCP connection that exchanges messages with a server. Each message is split into packets."""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from types import TracebackType

from drivers.vrep.wire.codec import Header, Piece, decode_message, encode_message
from drivers.vrep.wire.errors import NoServerError, ProtocolError, ServerLostError, ServerTimeoutError
from drivers.vrep.wire.requests import Identity
from robotcore.hal.wall_clock import MonotonicClock

TIMEOUT_S = 1.5
"""The default time limit of an exchange, in seconds.

It is so short that an app stops within two seconds after a server has failed.
"""

CONNECT_TIMEOUT_S = 1.2
"""The default time limit of connecting, in seconds.

It is longer than the half second for which a server does not listen after a client has disconnected.
"""

RETRY_S = 0.1
_QUICKACK: int | None = getattr(socket, "TCP_QUICKACK", None)
"""The number of a socket option of Linux; None on other systems."""

_CHUNK_BYTES = 1 << 18
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
        self._chunk = bytearray(_CHUNK_BYTES)
        self._assembler = AnswerAssembler()
        self.exchanges = 0
        """The number of replies that the server has sent."""

    @classmethod
    def open(cls, host: str, port: int, timeout_s: float = TIMEOUT_S, connect_timeout_s: float = 0.0) -> MessageSocket:
        """Connect to a server.

        timeout_s: time limit of an exchange, in seconds.
        connect_timeout_s: the time during which to try again if no server listens, in seconds.

        Raises NoServerError if no server listens.
        """
        clock = MonotonicClock()
        while True:
            try:
                return cls(_open_socket(host, port, timeout_s), f"the simulator at {host}:{port}", timeout_s)
            except NoServerError:
                if clock.now() + RETRY_S > connect_timeout_s:
                    raise
            clock.sleep_until(clock.now() + RETRY_S)

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

    @property
    def is_closed(self) -> bool:
        return self._socket.fileno() == -1

    def close(self) -> None:
        """Disconnect. In a thread that waits for a reply, `exchange` then raises an error.

        This method does not send the command that ends a connection. After this command the server would close the
        connection first, and the server's operating system would block the port for a minute.
        """
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()

    def __enter__(self) -> MessageSocket:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _exchange_message(self, message: bytes) -> bytes:
        deadline = self._clock.now() + self._timeout_s
        try:
            self._socket.settimeout(self._timeout_s)
            self._socket.sendall(encode_packets(message))
            return self._receive(deadline)
        except TimeoutError as error:
            raise self._timeout_error() from error
        except OSError as error:
            raise self._lost_error(error) from error

    def _receive(self, deadline: float) -> bytes:
        unpacker, view = Unpacker(), memoryview(self._chunk)
        while (left := deadline - self._clock.now()) > 0:
            self._socket.settimeout(left)
            self._enable_quick_ack()
            size = self._socket.recv_into(view)
            if size == 0:
                raise ConnectionResetError("end of data")
            if (message := unpacker.feed(view[:size])) is not None:
                return message
        raise TimeoutError

    def _enable_quick_ack(self) -> None:
        """Make the operating system acknowledge received packets at once. The system may reset this option at any time.

        A server delays each small packet until the previous one is acknowledged (Nagle's algorithm). Without this
        option, every second packet of an image would take 40 ms.
        """
        if _QUICKACK is not None:
            self._socket.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)

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


class Unpacker:
    """Decodes the packets of one message from received chunks of any size.

    >>> packets, unpacker = encode_packets(b"hello"), Unpacker()
    >>> unpacker.feed(packets[:8]), unpacker.feed(packets[8:])
    (None, b'hello')
    """

    def __init__(self) -> None:
        self._received = bytearray()
        self._message = bytearray()
        self._left: int | None = None

    def feed(self, chunk: bytes | memoryview) -> bytes | None:
        """Add received bytes. Return the message if it is complete, otherwise None.

        Raises ProtocolError if bytes follow the message, because a server sends one reply to each message.
        """
        self._received += chunk
        consumed = 0
        while self._left != 0 and (payload := self._find_payload(consumed)):
            self._message += memoryview(self._received)[payload]
            consumed = payload.stop
        del self._received[:consumed]
        if self._left != 0:
            return None
        if self._received:
            raise ProtocolError(f"{len(self._received)} bytes follow the end of the reply")
        return bytes(self._message)

    def _find_payload(self, start: int) -> slice | None:
        """Return the position of the payload of the packet that begins at ``start``; None if it is incomplete."""
        first = start + _PACKET_HEADER.size
        if len(self._received) < first:
            return None
        order, size, left = _PACKET_HEADER.unpack_from(self._received, start)
        if order != _BYTE_ORDER or size == 0 or (self._left is not None and left != self._left - 1):
            raise ProtocolError(_describe_header(bytes(self._received[start:first])))
        if len(self._received) < first + size:
            return None
        self._left = left
        return slice(first, first + size)


def _describe_header(header: bytes) -> str:
    if header == _ZEROMQ:
        return "it is the greeting of CoppeliaSim's ZeroMQ remote API (--backend coppeliasim)"
    return f"a packet begins with {header.hex(' ')}"
