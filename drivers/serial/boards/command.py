"""What a board's two motors are told, between the threads that tell it and the line's, which sends it."""

from __future__ import annotations

import math
from threading import Lock
from typing import NamedTuple

from drivers.serial.driver import Side

GATHER_S = 0.001
"""So long a command to one motor waits for the other's of the same tick, that both go in one frame."""

MAX_AGE_S = 0.25
"""What was not sent by then turns nothing any more: the program was suspended, and the motor stopped meanwhile."""

STOP_REPEAT_S = 0.1
"""So often boards that acknowledge nothing are told again that they stand."""


class WheelCommand(NamedTuple):
    """What the left and the right motor are told, in the board's own unit; positive is forward."""

    left: float = 0.0
    right: float = 0.0

    @property
    def stops(self) -> bool:
        """Whether both are to stand."""
        return not (self.left or self.right)


class CommandBuffer:
    """The newest command to both motors of a board; whoever tells one replaces what was not sent yet.

    A command is taken once for each time that a motor was told, so that the board's own time-out counts the app's
    silence. A frame has both motors, and that of the other one does not keep a motor turning: it stands in it when it
    was told nothing for as long as the board's time-out, as it would alone on the board; and for `MAX_AGE_S` where the
    frame is to stop the other one, lest it turn again.

    >>> command = CommandBuffer()
    >>> command.set("left", 2.0, now=0.0)
    >>> command.take(now=0.0, timeout_s=0.5), command.next_due
    (None, 0.001)
    >>> command.set("right", 3.0, now=0.0)
    >>> command.take(now=0.0, timeout_s=0.5), command.take(now=1.0, timeout_s=0.5)
    (Told(left=2.0, right=3.0), None)
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._newest = WheelCommand()
        self._set_at: dict[Side, float] = {}
        self._fresh: set[Side] = set()
        self._due = math.inf
        self._sent_at = -math.inf

    def set(self, side: Side, value: float, now: float) -> None:
        """Tell one motor; the other one keeps what it was told last."""
        with self._lock:
            self._newest = (
                WheelCommand(value, self._newest.right) if side == "left" else WheelCommand(self._newest.left, value)
            )
            self._set_at[side] = now
            self._fresh.add(side)
            is_complete = self._newest.stops or len(self._fresh) > 1
            self._due = min(self._due, now if is_complete else now + GATHER_S)

    def take(self, now: float, timeout_s: float) -> WheelCommand | None:
        """Return what is to be sent now, None where it was taken already or is still being gathered.

        ``timeout_s`` is the board's own time-out.
        """
        with self._lock:
            if now < self._due:
                return None
            self._newest = WheelCommand(self._in_force("left", now, timeout_s), self._in_force("right", now, timeout_s))
            self._fresh.clear()
            self._due, self._sent_at = math.inf, now
            return self._newest

    def repeat_stop(self, now: float) -> WheelCommand | None:
        """Return the stop, where both stand and were told so `STOP_REPEAT_S` ago: that may have been lost in noise.

        None where it is not time yet, or one turns: the board's own time-out counts from what the app told.
        """
        with self._lock:
            if not self._newest.stops or now < self._sent_at + STOP_REPEAT_S:
                return None
            self._sent_at = now
            return self._newest

    def clear(self) -> None:
        """Forget what was told: nothing is sent, and both stand, until one is told anew."""
        with self._lock:
            self._newest, self._due = WheelCommand(), math.inf
            self._fresh.clear()

    @property
    def newest(self) -> WheelCommand:
        """What both were told last, sent or not."""
        return self._newest

    @property
    def next_due(self) -> float:
        """When `take` has something, on the clock of ``now``; `inf` where nobody was told anything new."""
        return self._due

    @property
    def repeat_due(self) -> float:
        """When `repeat_stop` has something; `inf` where one turns."""
        return self._sent_at + STOP_REPEAT_S if self._newest.stops else math.inf

    def _in_force(self, side: Side, now: float, timeout_s: float) -> float:
        turns_anew = any(self._value(fresh) for fresh in self._fresh)
        lives_s = timeout_s if turns_anew and side not in self._fresh else MAX_AGE_S
        return 0.0 if now - self._set_at.get(side, -math.inf) > lives_s else self._value(side)

    def _value(self, side: Side) -> float:
        return self._newest.left if side == "left" else self._newest.right
