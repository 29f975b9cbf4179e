"""The base class of the protocols on a serial line."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar


class Protocol(ABC):
    """Converts received bytes to values, and commands to bytes. It does no input or output, and never waits.

    The thread of the line calls `begin`, `receive` and `data_to_send`. Devices set commands in other threads. So a
    command must be a single object that is replaced as a whole. All times are on the robot's clock, in seconds.
    """

    baud: int
    """The speed of the line in baud."""
    dtr: ClassVar[bool | None] = None
    """The level of the line DTR while the port is open; it is inverted on closing. None leaves it to the system."""
    is_ready: bool
    """Whether the board has sent data since the line was opened, and is not silent now. With boards that never send
    data: whether the boards accept commands."""

    @property
    def is_settled(self) -> bool:
        """Whether the last command was sent, and was acknowledged if the board acknowledges commands."""
        return True

    @property
    def timeout_notice(self) -> str:
        """A sentence for error messages, without full stop, about the board's time-out; empty without a time-out."""
        return ""

    @abstractmethod
    def begin(self, now: float) -> None:
        """Reset the protocol after the line was opened, because the board may have been reset.

        Drop all requests and commands, so that no motor turns before a new command.
        """

    @abstractmethod
    def receive(self, data: bytes, now: float) -> None:
        """Process received bytes. They may be cut at any place and have noise. No content raises an error."""

    @abstractmethod
    def data_to_send(self, now: float) -> bytes:
        """Return the bytes to send now; empty if there are none. The line sends all of them.

        The bytes have only the newest command, because commands are not queued.
        """

    def next_due(self, now: float) -> float:
        """Return the time of the next call of `data_to_send` if no new command is set; `inf` for no call."""
        return math.inf

    def explain_silence(self, place: str, *, has_received: bool = False) -> str:
        """Return the problem and the remedy if the board has sent no valid data since the line was opened.

        place: the port in the robot's file.
        has_received: whether any bytes were received.
        """
        if has_received:
            return (
                f"the data on {place} at {self.baud} baud is not that of this driver's board. Check the board, its "
                "firmware and its baud rate"
            )
        return (
            f"nothing on {place} answers at {self.baud} baud. Check that the board has power, is of the driver's kind, "
            "and has that baud rate"
        )
