"""Test protocols for a line, and the doubles at its other end."""

from __future__ import annotations

import math
from typing import NamedTuple

from drivers.serial.boards.board import CommandBuffer
from drivers.serial.protocol import Protocol
from tests.doubles.serial.board import BoardDouble


class ReceivedFrame(NamedTuple):
    """A numbered command at the far end of a line, and the time in seconds at which the line sent it."""

    number: int
    at: float


class Wire(BoardDouble):
    """The far end of a line, which records commands of `SIZE` bytes."""

    SIZE = 8

    def __init__(self) -> None:
        self.received: list[ReceivedFrame] = []

    def receive(self, data: bytes, now: float) -> bytes:
        numbers = (data[start : start + self.SIZE] for start in range(0, len(data), self.SIZE))
        self.received += [ReceivedFrame(int(number), now) for number in numbers]
        return b""


class NumberingProtocol(Protocol):
    """Sends numbers as commands to both motors, and only the newest number."""

    is_ready = True

    def __init__(self, baud: int) -> None:
        self.baud, self.command = baud, CommandBuffer()

    def begin(self, now: float) -> None:
        self.command.clear()

    def receive(self, data: bytes, now: float) -> None:
        """Ignore received bytes."""

    def data_to_send(self, now: float) -> bytes:
        wheels = self.command.take(now, timeout_s=0.5)
        return b"" if wheels is None else b"%0*d" % (Wire.SIZE, wheels.left)

    def next_due(self, now: float) -> float:
        return self.command.next_due

    def set(self, number: int, now: float) -> None:
        """Set the number as the command of both motors."""
        self.command.set("left", number, now)
        self.command.set("right", number, now)


class PollingProtocol(Protocol):
    """Sends ``?`` when the line opens, and then each word once. The board answers each of them."""

    is_settled: bool = True
    timeout_notice = "The board stops by itself after 0.5 s"

    def __init__(self, baud: int = 115200) -> None:
        self.baud = baud
        self.is_ready = False
        self.word = b""
        self.at = math.inf
        self.defect: Exception | None = None
        self.is_lost = False

    def set_word(self, word: bytes, at: float = -math.inf) -> None:
        self.is_settled, self.word, self.at = False, word, at

    def begin(self, now: float) -> None:
        self.is_ready = False
        self.set_word(b"?")

    def receive(self, data: bytes, now: float) -> None:
        self.is_ready = self.is_settled = True

    def data_to_send(self, now: float) -> bytes:
        if self.defect:
            raise self.defect
        self.is_ready = self.is_ready and not self.is_lost
        if now < self.at:
            return b""
        word, self.word, self.at = self.word, b"", math.inf
        return word

    def next_due(self, now: float) -> float:
        return self.at


class AnsweringBoard(BoardDouble):
    """Answers all received bytes unless ``is_deaf`` is true, and records them."""

    def __init__(self) -> None:
        self.received = b""
        self.is_deaf = False

    def receive(self, data: bytes, now: float) -> bytes:
        if not data or self.is_deaf:
            return b""
        self.received += data
        return b"!"
