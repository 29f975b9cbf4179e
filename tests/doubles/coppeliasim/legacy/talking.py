"""A client of the legacy remote API for the double's own tests: it says one message at a time."""

from __future__ import annotations

import socket
import struct
from types import TracebackType

from tests.doubles.coppeliasim.legacy.codec import Command, Header, pack, packed_up, read_message, unpack
from tests.doubles.coppeliasim.legacy.codes import Code, Mode
from tests.doubles.coppeliasim.legacy.comparing import Message

PATIENCE_S = 5.0


class Talker:
    """Connected to a port of this machine until it is closed; a context manager."""

    def __init__(self, port: int, patience_s: float = PATIENCE_S) -> None:
        self.line = socket.create_connection(("127.0.0.1", port), patience_s)
        self.line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._number = 0

    def __enter__(self) -> Talker:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.line.close()

    def say(self, *commands: Command) -> Message:
        """Send a message; return what is answered to it: what was done about the one before."""
        self.send(*commands)
        return unpack(read_message(self._receive))

    def send(self, *commands: Command) -> None:
        """Send a message and wait for nothing."""
        self.line.sendall(packed_up(pack(Header(self._number, 0), commands)))
        self._number += 1

    def ask(self, code: Code, identity: bytes = b"", data: bytes = b"") -> Command:
        """Return the reply to a command."""
        self.say(Command(code, Mode.BLOCKING, identity, data))
        _, (reply,) = self.say()
        return reply

    def _receive(self, size: int) -> bytes:
        return self.line.recv(size, socket.MSG_WAITALL)


def ints(*numbers: int) -> bytes:
    return struct.pack(f"<{len(numbers)}i", *numbers)


def floats(*numbers: float) -> bytes:
    return struct.pack(f"<{len(numbers)}f", *numbers)


def name(text: str) -> bytes:
    return text.encode() + b"\0"
