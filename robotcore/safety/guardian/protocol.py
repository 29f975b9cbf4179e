"""The messages between the app's process and its guardian, over a pair of sockets.

The app sends one line, the `Assignment`, and then single bytes: `BEGIN_LEASE`, `END_LEASE` and `END`. The guardian
answers received bytes with an empty line. It sends a `GuardianReply` as a line after each action. If the socket closes
before `END`, the app's process has died.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from socket import socket

from robotcore.hal.cutoff import CutoffSpec

BEGIN_LEASE = b"d"
"""The byte that begins a lease. The app sends it before a motor turns."""

END_LEASE = b"r"
"""The byte that ends the lease. The app sends it after every motor has stopped."""

END = b"q"
"""The byte that ends the guardian. The app sends it after the robot was closed."""

_CHUNK = 4096


@dataclass(frozen=True)
class Assignment:
    """The data that the guardian needs: the app's process, the cutoffs and the lease."""

    app: int
    """The number of the app's process."""

    lease: float
    """The time in seconds without a renewal after which the guardian stops the motors."""

    cutoffs: tuple[CutoffSpec, ...]

    def to_line(self) -> bytes:
        return _line(asdict(self))

    @classmethod
    def from_line(cls, line: bytes) -> Assignment:
        payload = json.loads(line)
        return cls(payload["app"], payload["lease"], tuple(CutoffSpec(**spec) for spec in payload["cutoffs"]))


@dataclass(frozen=True)
class GuardianReply:
    r"""The result of one action on all cutoffs.

    >>> GuardianReply("stop", done=("left_motor",), failed=("right_motor: does not answer",)).to_line()
    b'{"action": "stop", "done": ["left_motor"], "failed": ["right_motor: does not answer"], "messages": []}\n'
    """

    action: str
    """The name of a method of `Cutoff`."""

    done: tuple[str, ...]
    """The names of the devices on which the action succeeded."""

    failed: tuple[str, ...]
    """The devices on which the action failed, each with the problem: ``right_motor: does not answer``."""

    messages: tuple[str, ...] = ()
    """The texts that the cutoffs returned. The text of an `UnconfirmedStop` stop begins with the device."""

    def to_line(self) -> bytes:
        return _line(asdict(self))

    @classmethod
    def from_line(cls, line: bytes) -> GuardianReply:
        payload = json.loads(line)
        return cls(payload["action"], tuple(payload["done"]), tuple(payload["failed"]), tuple(payload["messages"]))


def receive(link: socket) -> bytes:
    """Return the bytes that have arrived. Return no bytes if the other process has closed its socket."""
    with suppress(ConnectionError):  # the other end was closed before it read all bytes
        return link.recv(_CHUNK)
    return b""


def read_line(link: socket) -> bytes:
    """Return the first line, without its line break. Raises EOFError if the link closes before the line break."""
    line = b""
    while not line.endswith(b"\n"):
        if not (more := receive(link)):
            raise EOFError
        line += more
    return line


class LineBuffer:
    """Assembles lines from the bytes that a socket receives piece by piece."""

    def __init__(self) -> None:
        self._begun = b""

    def add(self, piece: bytes) -> Iterator[bytes]:
        """Yield the lines that ``piece`` completes, without line breaks."""
        *whole, self._begun = (self._begun + piece).split(b"\n")
        yield from whole


def _line(payload: dict[str, object]) -> bytes:
    return json.dumps(payload).encode() + b"\n"
