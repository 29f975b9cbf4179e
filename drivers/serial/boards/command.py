"""The newest command to the two motors of a board, which the app's threads set and the line's thread sends."""

from __future__ import annotations

import math
from threading import Lock
from typing import NamedTuple

from drivers.serial.driver import Side

GATHER_S = 0.001
"""The longest wait, in seconds, of a command to one motor for a command to the other motor. One frame then has both."""

MAX_AGE_S = 0.25
"""The maximum age of a command when it is sent, in seconds; an older one is replaced by 0. Such a command waited
because the program was suspended, and the board may have stopped the motor."""

STOP_REPEAT_S = 0.1
"""The period of repeating a stop to a board that acknowledges no commands, in seconds."""


class WheelCommand(NamedTuple):
    """A command to both motors in the board's own unit, such as duty or m/s. Positive is forward."""

    left: float = 0.0
    right: float = 0.0

    @property
    def is_stop(self) -> bool:
        """Whether both values are 0."""
        return not (self.left or self.right)


class CommandBuffer:
    """The newest command to both motors of a board. A new command replaces an unsent one.

    Each command is sent only once, so that the board's own time-out measures the silence of the app. A frame has values
    for both motors. If only one motor has a new command, the frame has the previous value of the other motor. An old
    previous value is replaced by 0, because the board may have stopped that motor. Old means older than ``timeout_s``,
    or than `MAX_AGE_S` if the new command is a stop.
    """

    def __init__(self) -> None:
        self._lock = Lock()
        self._newest = WheelCommand()
        self._set_at: dict[Side, float] = {}
        self._fresh: set[Side] = set()
        self._due = math.inf
        self._sent_at = -math.inf

    def set(self, side: Side, value: float, now: float) -> None:
        """Set the command of one motor. The command of the other motor does not change."""
        with self._lock:
            self._newest = self._newest._replace(**{side: value})
            self._set_at[side] = now
            self._fresh.add(side)
            is_complete = self._newest.is_stop or len(self._fresh) > 1
            self._due = min(self._due, now if is_complete else now + GATHER_S)

    def take(self, now: float, timeout_s: float) -> WheelCommand | None:
        """Return the command to send now; None if there is none, or if it waits for the other motor's command.

        timeout_s: the board's own time-out in seconds.
        """
        with self._lock:
            if now < self._due:
                return None
            self._newest = WheelCommand(
                self._value_unless_old("left", now, timeout_s), self._value_unless_old("right", now, timeout_s)
            )
            self._fresh.clear()
            self._due, self._sent_at = math.inf, now
            return self._newest

    def repeat_stop(self, now: float) -> WheelCommand | None:
        """Return a stop if the newest command is a stop and was last sent `STOP_REPEAT_S` ago; else None.

        A stop is repeated because noise may have destroyed it. Other commands are not repeated, so that the board's
        time-out measures the silence of the app.
        """
        with self._lock:
            if not self._newest.is_stop or now < self._sent_at + STOP_REPEAT_S:
                return None
            self._sent_at = now
            return self._newest

    def clear(self) -> None:
        """Drop the command. Until `set` is called, `take` returns None and `newest` is a stop."""
        with self._lock:
            self._newest, self._due = WheelCommand(), math.inf
            self._fresh.clear()

    @property
    def newest(self) -> WheelCommand:
        """The newest command to both motors, sent or unsent."""
        return self._newest

    @property
    def next_due(self) -> float:
        """The time in seconds from which `take` returns a command; `inf` without a new command."""
        return self._due

    @property
    def repeat_due(self) -> float:
        """The time in seconds from which `repeat_stop` returns a stop; `inf` while a motor turns."""
        return self._sent_at + STOP_REPEAT_S if self._newest.is_stop else math.inf

    def _value_unless_old(self, side: Side, now: float, timeout_s: float) -> float:
        is_turning = any(getattr(self._newest, fresh) for fresh in self._fresh)
        max_age_s = timeout_s if is_turning and side not in self._fresh else MAX_AGE_S
        return 0.0 if now - self._set_at.get(side, -math.inf) > max_age_s else getattr(self._newest, side)
