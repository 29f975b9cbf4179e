"""The base class of the protocols on a serial line, without input and output."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod


class Protocol(ABC):
    """A protocol that takes and returns bytes: it does no input or output, and never waits.

    The thread of the line calls `begin`, `receive` and `data_to_send`. Devices set commands from other threads, so a
    command is one value that is replaced as a whole. Times are those of the robot's clock, in seconds.
    """

    baud: int
    """The speed of the line."""
    is_ready: bool
    """Whether the board has answered since the line was opened, and has not fallen silent. A protocol without answers
    is ready once a board would be."""

    @property
    def is_settled(self) -> bool:
        """Whether the last command was sent and, if the board acknowledges commands, acknowledged."""
        return True

    @property
    def timeout_notice(self) -> str:
        """A sentence on when the board stops its motors by itself if it receives no command; empty for never."""
        return ""

    @abstractmethod
    def begin(self, now: float) -> None:
        """Reset the protocol: the line was opened, and the board may have been reset.

        Drop requests and commands, so that no motor turns before a new command.
        """

    @abstractmethod
    def receive(self, data: bytes, now: float) -> None:
        """Take received bytes, cut anywhere and perhaps with noise. Never raises because of their content."""

    @abstractmethod
    def data_to_send(self, now: float) -> bytes:
        """Return the bytes to send now, perhaps none; the line calls this only if it is free, and sends them all.

        Only the newest command is sent: there is no queue of commands.
        """

    def next_due(self, now: float) -> float:
        """Return the latest time at which `data_to_send` has bytes again without a new command; `inf` for never."""
        return math.inf

    def explain_silence(self, place: str, *, has_heard: bool = False) -> str:
        """Return the fault and the remedy if the board has not answered since the line was opened.

        place: the port.
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
