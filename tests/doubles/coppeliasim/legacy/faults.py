"""Injected faults of a server. A fault is applied in place of sending a reply."""

from __future__ import annotations

import socket
import threading
from dataclasses import dataclass, field
from typing import Protocol


class ServerDiedError(Exception):
    """The server must close the connection."""


class Fault(Protocol):
    """Handles an encoded reply instead of sending it."""

    def send(self, line: socket.socket, answer: bytes) -> None:
        """Handle one reply. Raises ServerDiedError if the server must close the connection."""


@dataclass
class Hang:
    """Sends nothing until `release` is called. The connection stays open."""

    released: threading.Event = field(default_factory=threading.Event)

    def send(self, line: socket.socket, answer: bytes) -> None:
        self.released.wait()
        line.sendall(answer)

    def release(self) -> None:
        self.released.set()


@dataclass(frozen=True)
class DropConnection:
    """Sends ``sent`` bytes of a reply, then closes the connection."""

    sent: int = 0

    def send(self, line: socket.socket, answer: bytes) -> None:
        line.sendall(answer[: self.sent])
        raise ServerDiedError


@dataclass(frozen=True)
class CutReplies:
    """Sends only the first bytes of each reply, and continues."""

    sent: int

    def send(self, line: socket.socket, answer: bytes) -> None:
        line.sendall(answer[: self.sent])


@dataclass(frozen=True)
class SendGarbage:
    """Sends these bytes instead of each reply."""

    what: bytes

    def send(self, line: socket.socket, answer: bytes) -> None:
        line.sendall(self.what)
