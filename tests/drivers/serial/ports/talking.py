"""The smallest conversation there is, and the board at its other end."""

from __future__ import annotations

import math

from drivers.serial.protocol import Talk
from tests.doubles.serial.board import BoardDouble


class Asking(Talk):
    """Asks until it is answered, then says each word that it is told once; each is answered too."""

    is_settled: bool = True
    stops_itself = "The board stops by itself after 0.5 s"

    def __init__(self, baud: int = 115200) -> None:
        self.baud = baud
        self.is_ready = False
        self.word = b""
        self.at = math.inf
        self.defect: Exception | None = None
        self.is_lost = False

    def say(self, word: bytes, at: float = -math.inf) -> None:
        self.is_settled, self.word, self.at = False, word, at

    def begin(self, now: float) -> None:
        self.is_ready = False
        self.say(b"?")

    def receive(self, data: bytes, now: float) -> None:
        self.is_ready = self.is_settled = True

    def due(self, now: float) -> bytes:
        if self.defect:
            raise self.defect
        self.is_ready = self.is_ready and not self.is_lost
        if now < self.at:
            return b""
        word, self.word, self.at = self.word, b"", math.inf
        return word

    def next_due(self, now: float) -> float:
        return self.at


class Answering(BoardDouble):
    """Answers whatever it hears, where it is not ``deaf``, and keeps it, with the times."""

    def __init__(self) -> None:
        self.heard = b""
        self.is_deaf = False
        self.times: list[float] = []

    def hear(self, data: bytes, now: float) -> bytes:
        if not data or self.is_deaf:
            return b""
        self.heard += data
        self.times.append(now)
        return b"!"
