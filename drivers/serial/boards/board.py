"""The base class of the protocols of motor boards, with the newest command and the counters of the wheels."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from threading import Lock
from typing import ClassVar, NamedTuple

from drivers.serial.driver import Side
from drivers.serial.protocol import Protocol
from robotcore.kinds.battery import Voltage
from robotcore.kinds.encoder import Angle

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


class CountAccumulator:
    """Adds up the changes of one wheel's counter, in the board's own unit.

    After `restart`, the next count is the new reference, and the total does not change. The line's thread calls `add`,
    and the app's threads call `angle`.
    """

    def __init__(self, wraps_at: float | None = None) -> None:
        """Create an accumulator without a count.

        wraps_at: the number of counts after which the board's counter wraps around, 2³² for 32 bits; None if never.
        """
        self._wraps_at = wraps_at
        self._last: float | None = None
        self._newest: tuple[float, float, int] | None = None

    def add(self, count: float, time: float) -> None:
        """Add the change since the last count to the total.

        count: the value of the board's counter.
        time: the time of arrival of the count, in seconds.
        """
        total, _, sequence = self._newest or (0.0, 0.0, -1)
        total += self._difference(count)
        self._last = count
        self._newest = total, time, sequence + 1

    def restart(self) -> None:
        """Drop the last count after a reset of the board. The total does not change."""
        self._last = None

    def angle(self, rad_per_unit: float) -> Angle | None:
        """Return the angle of the wheel at the newest count; None before the first count."""
        if self._newest is None:
            return None
        total, time, sequence = self._newest
        return Angle(total * rad_per_unit, time, sequence)

    def _difference(self, count: float) -> float:
        if self._last is None:
            return 0.0
        return wrap_difference(count - self._last, self._wraps_at) if self._wraps_at else count - self._last


def wrap_difference(difference: float, wraps_at: float) -> float:
    """Return the difference of two values of a counter that wraps around at ``wraps_at``, from the shorter way."""
    return (difference + wraps_at / 2) % wraps_at - wraps_at / 2


class BoardProtocol(Protocol):
    """The base class of the protocols of boards that send data, on request or periodically.

    A board that has sent nothing for longer than `silence_s` is lost. The protocol drops the command when the board is
    lost, and again when the board sends data again. So a command that was set during the loss never turns a wheel.
    """

    default_timeout_s: ClassVar[float]
    """The board stops its motors after this many seconds without a command, unless `limit` sets a shorter time."""

    counters: Mapping[Side, CountAccumulator]
    """The counters of both wheels."""

    voltage: Voltage | None = None
    """The newest voltage of the battery; None before the first one."""

    def __init__(self, baud: int) -> None:
        self.baud, self.is_ready = baud, False
        self.command = CommandBuffer()
        self._timeouts_s: list[float] = []
        self._received_at = -math.inf

    @property
    @abstractmethod
    def silence_s(self) -> float:
        """The longest pause, in seconds, between two messages from a connected board."""

    def limit(self, timeout_s: float) -> None:
        """Lower the board's time-out to ``timeout_s`` seconds if it is longer. A fixed time-out does not change."""
        self._timeouts_s.append(timeout_s)

    @property
    def timeout_s(self) -> float:
        """The time without a command, in seconds, after which the board stops its motors."""
        return min(self._timeouts_s, default=self.default_timeout_s)

    @property
    def timeout_notice(self) -> str:
        return describe_timeout(self.timeout_s)

    @property
    def is_settled(self) -> bool:
        """Whether the newest command was sent."""
        return math.isinf(self.command.next_due)

    def begin(self, now: float) -> None:
        self._received_at = -math.inf
        self._lose(now)

    def _lose_if_silent(self, now: float) -> None:
        if self.is_ready and now - self._received_at > self.silence_s:
            self._lose(now)

    def _lose(self, now: float) -> None:
        self.is_ready = False
        self.command.clear()

    def _set_ready(self) -> None:
        self.command.clear()  # no motor turns before a new command
        self.is_ready = True

    def _set_voltage(self, volts: float, now: float) -> None:
        self.voltage = Voltage(volts, now, self.voltage.sequence + 1 if self.voltage else 0)


def describe_timeout(timeout_s: float) -> str:
    """Return the sentence for error messages, without full stop, that describes the time-out of a board."""
    return f"The board stops its motors by itself {timeout_s:g} s after the last command that it received"
