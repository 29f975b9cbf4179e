"""What conversations about two motors have in common, whatever the board speaks."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar

from drivers.serial.boards.command import Command
from drivers.serial.ports.talk import Talk


class BoardTalk(Talk):
    """A conversation with one board that answers, or tells by itself.

    A board that has told nothing for longer than `silence_s` is lost. What it was told is forgotten then, and once more
    when it is met again: a thread that was about to tell it something when it was lost turns no wheel later.
    """

    usual_timeout_s: ClassVar[float]
    """After how long without a command the board stops its motors by itself, where no motor asks for less."""

    def __init__(self, baud: int) -> None:
        self.baud, self.is_ready = baud, False
        self.command = Command()
        self._timeouts_s: list[float] = []
        self._heard_at = -math.inf

    @property
    @abstractmethod
    def silence_s(self) -> float:
        """How long a board that is there tells nothing at most."""

    def limit(self, timeout_s: float) -> None:
        """Have the board stop by itself after so long, if it can be told; the shortest time counts."""
        self._timeouts_s.append(timeout_s)

    @property
    def timeout_s(self) -> float:
        """After how long without a command the board stops its motors by itself."""
        return min(self._timeouts_s, default=self.usual_timeout_s)

    @property
    def stops_itself(self) -> str:
        return stops_after(self.timeout_s)

    @property
    def is_settled(self) -> bool:
        """Whether the newest command has been sent."""
        return math.isinf(self.command.next_due)

    def begin(self, now: float) -> None:
        self._heard_at = -math.inf
        self._lose(now)

    def _lose_if_silent(self, now: float) -> None:
        if self.is_ready and now - self._heard_at > self.silence_s:
            self._lose(now)

    def _lose(self, now: float) -> None:
        """Know that the board is gone, or was reset."""
        self.is_ready = False
        self.command.forget()

    def _meet(self) -> None:
        """Know that the board is there; it stands until it is told anew."""
        self.command.forget()
        self.is_ready = True


def stops_after(timeout_s: float) -> str:
    """Say when a board stops by itself.

    >>> stops_after(0.5)
    'The board stops its motors by itself 0.5 s after the last command that it heard.'
    """
    return f"The board stops its motors by itself {timeout_s:g} s after the last command that it heard."
