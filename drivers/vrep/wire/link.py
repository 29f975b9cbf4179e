"""One TCP connection to a server that answers every message with one message."""

from __future__ import annotations

import socket
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from types import TracebackType

from drivers.vrep.wire.codec import Header, Piece, Unpacker, decode_message, encode_message, encode_packets
from drivers.vrep.wire.errors import NobodyListensError, ServerHangsError, ServerLostError
from drivers.vrep.wire.requests import Identity
from robotcore.hal.wall_clock import MonotonicClock

TIMEOUT_S = 1.5
"""A server that takes longer over a message is taken for dead: an app is to stop within two seconds."""

PATIENCE_S = 1.2
"""A server does not listen for half a second after a client has left."""

RETRY_S = 0.1
_QUICKACK: int | None = getattr(socket, "TCP_QUICKACK", None)
"""Linux has it."""

_CHUNK_BYTES = 1 << 18
_CLIENT_TIME_MASK = 0x03FFFFFF


class Link:
    """A line on which one message at a time is exchanged; the first error ends it. For one thread at a time."""

    def __init__(self, line: socket.socket, name: str, timeout_s: float) -> None:
        self._line, self._name, self._timeout_s = line, name, timeout_s
        self._clock = MonotonicClock()
        self._chunk = bytearray(_CHUNK_BYTES)
        self._assembly = Assembly()
        self.exchanges = 0

    @classmethod
    def to(cls, host: str, port: int, timeout_s: float = TIMEOUT_S, patience_s: float = 0.0) -> Link:
        """Connect to a server; where nobody listens, try again for ``patience_s``."""
        clock = MonotonicClock()
        while True:
            try:
                return cls(_line_to(host, port, timeout_s), f"the simulator at {host}:{port}", timeout_s)
            except NobodyListensError:
                if clock.now() + RETRY_S > patience_s:
                    raise
            clock.sleep_until(clock.now() + RETRY_S)

    def exchange(self, number: int, commands: Iterable[bytes]) -> tuple[Header, list[Piece]]:
        """Send a message of that number; return the server's state and all whole answers that have come with its reply.

        The answers to these commands come with a later reply, when the simulator's main thread has done them.
        """
        try:
            header, pieces = decode_message(self._reply_to(encode_message(number, self._client_time_ms(), commands)))
        except BaseException:
            self.close()
            raise
        self.exchanges += 1
        return header, [whole for piece in pieces if (whole := self._assembly.whole(piece))]

    @property
    def is_closed(self) -> bool:
        return self._line.fileno() == -1

    def close(self) -> None:
        """Hang up, also on a thread that waits for a reply.

        No command ends the connection before: the server would close it first then, and its system would keep the port
        from everyone for a minute.
        """
        with suppress(OSError):
            self._line.shutdown(socket.SHUT_RDWR)
        self._line.close()

    def __enter__(self) -> Link:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _reply_to(self, message: bytes) -> bytes:
        deadline = self._clock.now() + self._timeout_s
        try:
            self._line.settimeout(self._timeout_s)
            self._line.sendall(encode_packets(message))
            return self._received(deadline)
        except TimeoutError as error:
            raise ServerHangsError(self._why_silent()) from error
        except OSError as error:
            raise ServerLostError(self._why_lost(error)) from error

    def _received(self, deadline: float) -> bytes:
        unpacker, view = Unpacker(), memoryview(self._chunk)
        while (left := deadline - self._clock.now()) > 0:
            self._line.settimeout(left)
            self._acknowledge_at_once()
            size = self._line.recv_into(view)
            if size == 0:
                raise ConnectionResetError("it hung up")
            if (message := unpacker.feed(view[:size])) is not None:
                return message
        raise TimeoutError

    def _acknowledge_at_once(self) -> None:
        """Ask the system not to wait with what it acknowledges; it forgets that now and then.

        A server holds back each small packet until the one before is acknowledged (Nagle's algorithm), and an image is
        many: without this, one in two takes 40 ms.
        """
        if _QUICKACK is not None:
            self._line.setsockopt(socket.IPPROTO_TCP, _QUICKACK, 1)

    def _client_time_ms(self) -> int:
        return int(self._clock.now() * 1000) & _CLIENT_TIME_MASK

    def _why_lost(self, error: OSError) -> str:
        if self.exchanges:
            ending = "Was it closed, its scene stopped, or killed? Start it and run again"
            return f"{self._name} is gone ({error}). {ending}"
        return (
            f"{self._name} takes the connection and hangs up ({error}). A port serves one program at a time: end the "
            "other one, or take another port"
        )

    def _why_silent(self) -> str:
        if self.exchanges:
            return f"{self._name} has not answered for {self._timeout_s:g} s. If it hangs, restart it and run again"
        return (
            f"{self._name} takes the connection and says nothing for {self._timeout_s:g} s. A port serves one program "
            "at a time: end the other one, or take another port"
        )


def _line_to(host: str, port: int, timeout_s: float) -> socket.socket:
    try:
        line = socket.create_connection((host, port), timeout_s)
    except (OSError, UnicodeError) as error:  # of what is no name of a machine's
        raise NobodyListensError(
            f"nobody answers at {host}:{port} ({error}). Start the simulator, or give its port with --port: "
            "19997 as it is shipped, 19999 where a script of a running scene has called simRemoteApi.start(19999)"
        ) from error
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return line


class Assembly:
    """Keeps pieces until their answer is whole. An answer of another size begins anew."""

    def __init__(self) -> None:
        self._begun: dict[Identity, bytearray] = {}

    def whole(self, piece: Piece) -> Piece | None:
        """Return the answer if this piece makes it whole."""
        if piece.is_whole:
            return piece
        identity = piece.command, piece.key
        begun = self._begun.get(identity)
        if begun is None or len(begun) != piece.total:
            begun = self._begun[identity] = bytearray(piece.total)
        end = piece.offset + len(piece.data)
        begun[piece.offset : end] = piece.data
        if end < piece.total:
            return None
        return replace(piece, data=memoryview(bytes(self._begun.pop(identity))), offset=0)
