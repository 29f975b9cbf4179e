"""The base class of the protocols of motor boards."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from drivers.serial.boards.command import CommandBuffer
from drivers.serial.boards.devices import CountAccumulator
from drivers.serial.driver import Side
from drivers.serial.protocol import Protocol
from robotcore.hal.devices import Voltage


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
