"""One request of the legacy remote API: a command, what it is about, and how its answer is read."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from drivers.vrep.wire.errors import GarbledReplyError, RefusedError
from drivers.vrep.wire.messages import Piece, encoded_command

T_co = TypeVar("T_co", covariant=True)

ONESHOT = 0x000000
BLOCKING = 0x010000
STREAMING = 0x020000
ONESHOT_SPLIT = 0x030000
STREAMING_SPLIT = 0x040000
DISCONTINUE = 0x050000
BUFFER = 0x060000
REMOVE = 0x070000

Identity = tuple[int, bytes]
"""A command's number and its key: a later command of the same identity takes the place of an earlier one."""


@dataclass(frozen=True)
class Request(Generic[T_co]):
    """Ask ``command`` about ``key``, the handles or names it concerns, with ``data``; ``decode`` reads the answer.

    ``words`` are for error messages.
    """

    words: str
    command: int
    key: bytes
    data: bytes
    decode: Callable[[memoryview], T_co] = field(compare=False)

    @property
    def identity(self) -> Identity:
        return self.command, self.key

    def encoded(self, mode: int = ONESHOT, delay: int = 0) -> bytes:
        """Return it as it stands in a message."""
        return encoded_command(self.command, mode, delay, self.key, self.data)

    def read(self, answer: Piece) -> T_co:
        """Return the value in an answer; RefusedError if the server could not do it."""
        if answer.is_failed:
            raise RefusedError(f"the simulator refused to {self.words}")
        try:
            return self.decode(answer.data)
        except (struct.error, ValueError) as error:
            raise GarbledReplyError(f"{len(answer.data)} bytes answer the request to {self.words}") from error
