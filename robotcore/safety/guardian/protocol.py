"""The messages between the app's process and its guardian, over a pair of sockets.

The app sends one line, the `Assignment`, and then single bytes. The guardian answers each piece of bytes by an empty
line, and sends a `Report` as a line for each action. If the app's bytes end without `BYE`, the app has died.
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
"""The robot is closed; the guardian ends."""

_CHUNK = 4096


@dataclass(frozen=True)
class Assignment:
    """The motors that the guardian guards."""

    app: int
    """The number of the app's process."""

    lease: float
    """The guardian stops the motors if no command comes for this many seconds."""

    cutoffs: tuple[CutoffSpec, ...]

    def to_line(self) -> bytes:
        return _line(asdict(self))

    @classmethod
    def from_line(cls, line: bytes) -> Assignment:
        payload = json.loads(line)
        return cls(payload["app"], payload["lease"], tuple(CutoffSpec(**spec) for spec in payload["cutoffs"]))


@dataclass(frozen=True)
class Report:
    r"""The result of one action on all cutoffs.

    >>> Report("stop", done=("left_motor",), failed=("right_motor: does not answer",)).to_line()
    b'{"action": "stop", "done": ["left_motor"], "failed": ["right_motor: does not answer"], "messages": []}\n'
    """

    action: str
    """A method of `Cutoff`."""

    done: tuple[str, ...]
    """The devices on which the action succeeded."""

    failed: tuple[str, ...]
    """The devices on which the action failed, each with its fault."""

    messages: tuple[str, ...] = ()
    """Sentences that cutoffs returned, such as a program that was ended, and devices with an `Unconfirmed` stop."""

    def to_line(self) -> bytes:
        return _line(asdict(self))

    @classmethod
    def from_line(cls, line: bytes) -> Report:
        payload = json.loads(line)
        return cls(payload["action"], tuple(payload["done"]), tuple(payload["failed"]), tuple(payload["messages"]))


def receive(link: socket, flags: int = 0) -> bytes:
    """Return the bytes that have arrived; no bytes if the other end is closed."""
    with suppress(ConnectionError):  # the other end closed with unread bytes
        return link.recv(_CHUNK, flags)
    return b""


def read_line(link: socket) -> bytes:
    """Return the first line, without its end; raises EOFError if the link closes before the line is complete."""
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

    def add(self, piece: bytes) -> Iterator[bytes]:
        """Yield the lines that ``piece`` completes, without their ends."""
        *whole, self._begun = (self._begun + piece).split(b"\n")
        yield from whole


def _line(payload: dict[str, object]) -> bytes:
    return json.dumps(payload).encode() + b"\n"
