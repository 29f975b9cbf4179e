"""What is said on a line, without the line: a protocol's side of the conversation."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod


class Protocol(ABC):
    """One side of a conversation, fed with bytes and asked for bytes: it does no input or output, and never waits.

    The line's thread calls `begin`, `receive` and `due`; devices tell it from other threads what they want sent, so
    that is kept in values that are replaced whole. Times are of the robot's clock, in seconds.

    ``baud`` is the line's speed; ``is_ready`` whether the other side is there: it has answered since the line was
    opened, as far as it ever does, and goes on doing so where it is asked all the time.
    """

    baud: int
    is_ready: bool

    @property
    def is_settled(self) -> bool:
        """Whether the last command has been sent and, where the board acknowledges, heard."""
        return True

    @property
    def stops_itself(self) -> str:
        """When the board stops its motors by itself where nobody is heard, in a whole sentence; empty for never."""
        return ""

    @abstractmethod
    def begin(self, now: float) -> None:
        """Begin anew: the line is open, first or again, and the board may have been reset.

        What was under way and what was commanded is forgotten; nothing turns until it is told anew.
        """

    @abstractmethod
    def receive(self, data: bytes, now: float) -> None:
        """Take what has come in: any cut of the stream, noise and all. Never raises for what it is."""

    @abstractmethod
    def due(self, now: float) -> bytes:
        """Return what is to be sent now, empty where it is nothing; asked only when the line is free.

        What is returned will have been sent: the newest command, never a queue of them.
        """

    def next_due(self, now: float) -> float:
        """Return when `due` has something again at the latest, if nobody wants anything before; `inf` for never."""
        return math.inf

    def unanswered(self, place: str, *, has_heard: bool = False) -> str:
        """Say what is wrong where nobody on that place has answered since the line was opened, and what to do.

        ``has_heard`` is whether anything came at all.
        """
        if has_heard:
            return (
                f"something speaks on {place}, but not what this driver's board does at {self.baud} baud. Look whether "
                "it is that board, with that firmware, and speaks at that baud"
            )
        return (
            f"nothing on {place} answers at {self.baud} baud. Look whether the board has power, is the one that driver "
            "is for, and speaks at that baud"
        )
