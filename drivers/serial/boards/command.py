"""The newest command to a board's two motors, passed from the app's threads to the line's thread."""

from __future__ import annotations

import math
from threading import Lock
from typing import NamedTuple

from drivers.serial.driver import Side

GATHER_S = 0.001
"""A command waits this long for the other motor's command of the same tick, so that both go in one frame."""

MAX_AGE_S = 0.25
"""An older command is sent as 0: the program was suspended, and the board has stopped the motor meanwhile."""

STOP_REPEAT_S = 0.1
"""The period of repeating a stop to boards that acknowledge nothing."""


class WheelCommand(NamedTuple):
    """A command to the left and the right motor, in the board's own unit; positive is forward."""

    left: float = 0.0
    right: float = 0.0

    @property
    def is_stop(self) -> bool:
        """Whether both values are 0."""
        return not (self.left or self.right)


class CommandBuffer:
    """The newest command to both motors of a board; a new command replaces one that was not sent yet.

    Each command is taken once, so that the board's own time-out measures how long the app is silent. A frame always
    carries both motors. A motor that has had no command for ``timeout_s`` is sent 0. If the frame stops the other
    motor, the limit is `MAX_AGE_S`, so that the frame does not start this motor again.

    >>> command = CommandBuffer()
    >>> command.set("left", 2.0, now=0.0)
    >>> command.take(now=0.0, timeout_s=0.5), command.next_due
    (None, 0.001)
    >>> command.set("right", 3.0, now=0.0)
    >>> command.take(now=0.0, timeout_s=0.5), command.take(now=1.0, timeout_s=0.5)
    (WheelCommand(left=2.0, right=3.0), None)
    """

    def __init__(self) -> None:
        """Start with a stop that is not sent."""
        self._lock = Lock()
        self._newest = WheelCommand()
        self._set_at: dict[Side, float] = {}
        self._fresh: set[Side] = set()
        self._due = math.inf
        self._sent_at = -math.inf

    def __repr__(self) -> str:
        state = "sent" if math.isinf(self._due) else f"due at {self._due:g}"
        return f"CommandBuffer(left={self._newest.left:g}, right={self._newest.right:g}, {state})"

    def set(self, side: Side, value: float, now: float) -> None:
        """Set the command of one motor; the other one keeps its newest command."""
        with self._lock:
            self._newest = (
                WheelCommand(value, self._newest.right) if side == "left" else WheelCommand(self._newest.left, value)
            )
            self._set_at[side] = now
            self._fresh.add(side)
            is_complete = self._newest.is_stop or len(self._fresh) > 1
            self._due = min(self._due, now if is_complete else now + GATHER_S)

    def take(self, now: float, timeout_s: float) -> WheelCommand | None:
        """Return the command to send now; None if it was taken already, or waits for the other motor's.

        timeout_s: the board's own time-out in seconds.
        """
        with self._lock:
            if now < self._due:
                return None
            self._newest = WheelCommand(self._in_force("left", now, timeout_s), self._in_force("right", now, timeout_s))
            self._fresh.clear()
            self._due, self._sent_at = math.inf, now
            return self._newest

    def repeat_stop(self, now: float) -> WheelCommand | None:
        """Return the stop again if it was sent `STOP_REPEAT_S` ago: noise may have destroyed it.

        Returns None before that time, and while a motor turns: the board's time-out counts from the app's commands.
        """
        with self._lock:
            if not self._newest.is_stop or now < self._sent_at + STOP_REPEAT_S:
                return None
            self._sent_at = now
            return self._newest

    def clear(self) -> None:
        """Drop the command: nothing is sent, and both values are 0, until a new one is set."""
        with self._lock:
            self._newest, self._due = WheelCommand(), math.inf
            self._fresh.clear()

    @property
    def newest(self) -> WheelCommand:
        """The newest command of both motors, sent or not."""
        return self._newest

    @property
    def next_due(self) -> float:
        """When `take` has a command, on the clock of ``now``; `inf` if there is no new one."""
        return self._due

    @property
    def repeat_due(self) -> float:
        """When `repeat_stop` has a command; `inf` while a motor turns."""
        return self._sent_at + STOP_REPEAT_S if self._newest.is_stop else math.inf

    def _in_force(self, side: Side, now: float, timeout_s: float) -> float:
        is_turning = any(self._value(fresh) for fresh in self._fresh)
        max_age_s = timeout_s if is_turning and side not in self._fresh else MAX_AGE_S
        return 0.0 if now - self._set_at.get(side, -math.inf) > max_age_s else self._value(side)

    def _value(self, side: Side) -> float:
        return self._newest.left if side == "left" else self._newest.right
