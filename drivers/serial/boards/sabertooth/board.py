"""What is said on a line with Sabertooths: to each by its address, and nobody answers."""

from __future__ import annotations

import math

from drivers.serial.boards.board import stops_after
from drivers.serial.boards.command import CommandBuffer, WheelCommand
from drivers.serial.boards.sabertooth.protocol import BAUDING, MOST_TIMEOUT_S, drive, in_tenths, timeout
from drivers.serial.protocol import Protocol

SETTLING_S = 0.5
"""So long a board takes to its baud rate after the first byte."""


class AddressedBoard:
    """One board: what its two motors are told, M1 the left and M2 the right, and its own time-out in seconds."""

    def __init__(self, address: int) -> None:
        self.address = address
        self.command = CommandBuffer()
        self.timeout_s = MOST_TIMEOUT_S

    def frames(self, wheels: WheelCommand) -> bytes:
        """Return what tells it both, and its time-out again: a board that was off has forgotten that."""
        motors = drive(self.address, 1, wheels.left) + drive(self.address, 2, wheels.right)
        return motors + timeout(self.address, self.timeout_s)


class SabertoothProtocol(Protocol):
    """Tells each board its newest command, boards that are to stand first.

    Nobody answers, so it is ready when a board would be that is there. While all stand they are told so again and
    again; while one turns nothing is repeated, for a board's time-out may begin anew with any frame on the line.
    """

    def __init__(self, baud: int) -> None:
        self.baud = baud
        self._boards: dict[int, AddressedBoard] = {}
        self._ready_at = -math.inf
        self.is_ready = self._is_new = False

    def board(self, address: int, timeout_s: float) -> AddressedBoard:
        """Return the board with that address, whose time-out is the shortest that anyone asked for, in whole tenths."""
        board = self._boards.get(address) or AddressedBoard(address)
        board.timeout_s = min(board.timeout_s, in_tenths(timeout_s))
        self._boards = {**self._boards, address: board}
        return board

    def begin(self, now: float) -> None:
        self.is_ready = False
        self._is_new = True
        self._ready_at = now + SETTLING_S
        self._forget()

    def receive(self, data: bytes, now: float) -> None:
        """Hear nothing: what comes is an echo, or noise."""

    def due(self, now: float) -> bytes:
        if self._is_new:
            self._is_new = False
            return BAUDING
        if now < self._ready_at:
            return b""
        if not self.is_ready:
            self._forget()
            self.is_ready = True
        return self._new_commands(now) or self._repeated_stops(now)

    def next_due(self, now: float) -> float:
        if now < self._ready_at:
            return now if self._is_new else self._ready_at
        commands = [board.command for board in self._boards.values()]
        again = min((command.repeat_due for command in commands), default=math.inf) if self._stands else math.inf
        return min((again, *(command.next_due for command in commands)))

    @property
    def is_settled(self) -> bool:
        """Whether the last command was sent; whether it was heard nobody tells."""
        return all(board.command.next_due == math.inf for board in self._boards.values())

    @property
    def stops_itself(self) -> str:
        longest = max((board.timeout_s for board in self._boards.values()), default=MOST_TIMEOUT_S)
        return stops_after(longest)

    @property
    def _stands(self) -> bool:
        return all(board.command.newest.stops for board in self._boards.values())

    def _new_commands(self, now: float) -> bytes:
        """Return what one board is told, the next one's turn being when the line is free again."""
        for board in sorted(self._boards.values(), key=lambda board: not board.command.newest.stops):
            if (wheels := board.command.take(now, board.timeout_s)) is not None:
                return board.frames(wheels)
        return b""

    def _repeated_stops(self, now: float) -> bytes:
        if not self._stands:
            return b""
        again = ((board, board.command.repeat_stop(now)) for board in self._boards.values())
        return b"".join(board.frames(wheels) for board, wheels in again if wheels)

    def _forget(self) -> None:
        for board in self._boards.values():
            board.command.clear()
