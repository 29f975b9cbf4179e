"""Ways in which a server can fail its client: each takes the place of sending an answer."""

from __future__ import annotations

import socket
import threading
from dataclasses import dataclass, field
from typing import Protocol


class ServerDiedError(Exception):
    """The connection is to be torn down."""


class Fault(Protocol):
    """Does something with an answer, which is ready for the line, other than to send it."""

    def send(self, line: socket.socket, answer: bytes) -> None:
        """Treat one answer; ServerDiedError where the connection does not outlive it."""


@dataclass
class Hang:
    """Sends nothing, and does nothing else, until it is released; the connection stays open."""

    released: threading.Event = field(default_factory=threading.Event)

    def send(self, line: socket.socket, answer: bytes) -> None:
        self.released.wait()
        line.sendall(answer)

    def release(self) -> None:
        """Go on."""
        self.released.set()


@dataclass(frozen=True)
class DropConnection:
    """Sends so many bytes of an answer, then is gone."""

    sent: int = 0

    def send(self, line: socket.socket, answer: bytes) -> None:
        line.sendall(answer[: self.sent])
        raise ServerDiedError


@dataclass(frozen=True)
class CutReplies:
    """Sends so many bytes of every answer, and goes on as if that were all."""

    sent: int

    def send(self, line: socket.socket, answer: bytes) -> None:
        line.sendall(answer[: self.sent])


@dataclass(frozen=True)
class SendGarbage:
    """Sends these bytes in place of every answer."""

    what: bytes

    def send(self, line: socket.socket, answer: bytes) -> None:
        line.sendall(self.what)
