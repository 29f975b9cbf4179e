"""What the app's process and its guardian say to each other, over a pair of sockets.

From the app: one line, the `Assignment`, then single bytes. From the guardian: a line for whatever it has done, and an
empty one for what it has receive. The end of the app's bytes without `BYE` is the end of the app.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from socket import socket

from robotcore.hal.cutoff import CutoffSpec

DRIVING = b"d"
"""A motor is about to turn; a lease begins."""

RESTING = b"r"
"""Every motor stands; the lease ends until the next command."""

BYE = b"q"
"""The robot is closed: the guardian may go."""

_CHUNK = 4096


@dataclass(frozen=True)
class Assignment:
    """What the guardian is to guard: the motors of which process, and for how many seconds a command may live."""

    app: int
    lease: float
    cutoffs: tuple[CutoffSpec, ...]

    def to_line(self) -> bytes:
        return _line(asdict(self))

    @classmethod
    def from_line(cls, line: bytes) -> Assignment:
        payload = json.loads(line)
        return cls(payload["app"], payload["lease"], tuple(CutoffSpec(**spec) for spec in payload["cutoffs"]))


@dataclass(frozen=True)
class Report:
    """What the guardian did, a method of `Cutoff`: on which devices, and where it failed, each with its fault.

    messages: what it had to do besides, as sentences, and devices of which it is `Unconfirmed`.
    """

    deed: str
    done: tuple[str, ...]
    failed: tuple[str, ...]
    messages: tuple[str, ...] = ()

    def to_line(self) -> bytes:
        return _line(asdict(self))

    @classmethod
    def from_line(cls, line: bytes) -> Report:
        payload = json.loads(line)
        return cls(payload["deed"], tuple(payload["done"]), tuple(payload["failed"]), tuple(payload["messages"]))


def receive(link: socket, flags: int = 0) -> bytes:
    """Return what has come; nothing once the other end is gone."""
    with suppress(ConnectionError):  # what it was sent, it may have left unread
        return link.recv(_CHUNK, flags)
    return b""


def read_line(link: socket) -> bytes:
    """Return the first line, without its end; EOFError where the other end goes before it is whole."""
    line = b""
    while not line.endswith(b"\n"):
        if not (more := receive(link)):
            raise EOFError
        line += more
    return line


class LineBuffer:
    """Joins received pieces to lines."""

    def __init__(self) -> None:
        self._begun = b""

    def of(self, piece: bytes) -> Iterator[bytes]:
        """Yield the lines that ``piece`` makes whole, without their ends."""
        *whole, self._begun = (self._begun + piece).split(b"\n")
        yield from whole


def _line(payload: dict[str, object]) -> bytes:
    return json.dumps(payload).encode() + b"\n"
