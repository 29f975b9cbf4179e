"""The base class of the protocols on a serial line, which do no input or output themselves."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod


class Protocol(ABC):
    """Converts received bytes to values, and commands to bytes. It does no input or output, and never waits.

    The thread of the line calls `begin`, `receive` and `data_to_send`. Devices set commands in other threads, so a
    command must be one value that is replaced as a whole. All times are on the robot's clock, in seconds.
    """

    baud: int
    """The speed of the line in baud."""
    is_ready: bool
    """Whether the board has answered since the line was opened, and is not silent now. If boards send no answers, it is
    true as soon as a board accepts commands."""

    @property
    def is_settled(self) -> bool:
        """Whether the last command was sent and, if the board acknowledges commands, acknowledged."""
        return True

    @property
    def timeout_notice(self) -> str:
        """A sentence with the board's time-out, after which it stops its motors; empty if it has no time-out."""
        return ""

    @abstractmethod
    def begin(self, now: float) -> None:
        """Reset the protocol after the line was opened, because the board may have been reset.

        Drop all requests and commands, so that no motor turns before a new command.
        """

    @abstractmethod
    def receive(self, data: bytes, now: float) -> None:
        """Process received bytes.

        They arrive in pieces of any length and may have noise; no content raises an error.
        """

    @abstractmethod
    def data_to_send(self, now: float) -> bytes:
        """Return the bytes to send now, perhaps none. The line calls this if it can send, and sends all of them.

        Only the newest command is sent. There is no queue of commands.
        """

    def next_due(self, now: float) -> float:
        """Return the time at which `data_to_send` must be called again if no new command is set; `inf` for never."""
        return math.inf

    def explain_silence(self, place: str, *, has_heard: bool = False) -> str:
        """Return the fault and the remedy for a board that has not answered since the line was opened.

        place: the port in the robot's file.
        has_heard: whether any bytes were received.
        """
        if has_heard:
            return (
                f"the data on {place} at {self.baud} baud is not that of this driver's board. Check the board, its "
                "firmware and its baud rate"
            )
        return (
            f"nothing on {place} answers at {self.baud} baud. Check that the board has power, is of the driver's kind, "
            "and has that baud rate"
        )
