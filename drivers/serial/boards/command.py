"""What a board's two motors are told, between the threads that tell it and the line's, which sends it."""

from __future__ import annotations

import math
from threading import Lock
from typing import NamedTuple

from drivers.serial.boards.settings import Side

GATHERING_S = 0.001
"""So long a command that turns one motor waits for the other's of the same tick, that both go in one frame."""

OLD_S = 0.5
"""A command that could not be sent for so long, as in a program that was suspended, turns nothing any more."""


class Told(NamedTuple):
    """What the left and the right motor are told, in the board's own unit; positive is forward."""

    left: float = 0.0
    right: float = 0.0

    @property
    def stops(self) -> bool:
        """Whether both are to stand."""
        return not (self.left or self.right)


class Command:
    """The newest command to both motors of a board; whoever tells one replaces what was not sent yet.

    A command is taken once for each time that a motor was told, so that the board's own time-out counts the app's
    silence. A motor that is told to stand does not wait for the other one's command. One that was told to turn too long
    ago is told to stand instead.

    >>> command = Command()
    >>> command.tell("left", 2.0, now=0.0)
    >>> command.take(now=0.0), command.next_due
    (None, 0.001)
    >>> command.tell("right", 3.0, now=0.0)
    >>> command.take(now=0.0), command.take(now=1.0)
    (Told(left=2.0, right=3.0), None)
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._told = Told()
        self._fresh: set[Side] = set()
        self._due = math.inf
        self._told_at = -math.inf

    def tell(self, side: Side, value: float, now: float) -> None:
        """Tell one motor; the other one keeps what it was told last."""
        with self._lock:
            self._told = Told(value, self._told.right) if side == "left" else Told(self._told.left, value)
            self._told_at = now
            self._fresh.add(side)
            is_complete = value == 0 or len(self._fresh) > 1
            self._due = min(self._due, now if is_complete else now + GATHERING_S)

    def take(self, now: float) -> Told | None:
        """Return what is to be sent now, None where it was taken already or is still being gathered."""
        with self._lock:
            if now < self._due:
                return None
            self._fresh.clear()
            self._due = math.inf
            if now - self._told_at > OLD_S:
                self._told = Told()
            return self._told

    def forget(self) -> None:
        """Forget what was told: nothing is sent, and both stand, until one is told anew."""
        with self._lock:
            self._told, self._due = Told(), math.inf
            self._fresh.clear()

    @property
    def told(self) -> Told:
        """What both were told last, sent or not; a board that wants to hear again that it stands is told this."""
        return self._told

    @property
    def next_due(self) -> float:
        """When `take` has something, on the clock of ``now``; `inf` where nobody was told anything new."""
        return self._due
