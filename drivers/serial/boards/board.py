"""The base class of the protocols of motor boards, and an open board, which several devices share."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar, Generic, TypeVar

from drivers.serial.boards.command import CommandBuffer
from drivers.serial.line import Line
from drivers.serial.protocol import Protocol
from robotcore.errors import DeviceError
from robotcore.hardware import Host


class BoardProtocol(Protocol):
    """The base class of protocols for one board, which answers requests or sends data by itself.

    A board that has sent nothing for longer than `silence_s` is lost. The protocol drops the command when the board is
    lost, and again when the board is back. So a command that was set during the loss never turns a wheel.
    """

    default_timeout_s: ClassVar[float]
    """The board stops its motors after this many seconds without a command, unless `limit` sets a shorter time."""

    def __init__(self, baud: int) -> None:
        self.baud, self.is_ready = baud, False
        self.command = CommandBuffer()
        self._timeouts_s: list[float] = []
        self._heard_at = -math.inf

    @property
    @abstractmethod
    def silence_s(self) -> float:
        """The longest time, in seconds, between two messages of a connected board."""

    def limit(self, timeout_s: float) -> None:
        """Lower the time-out of the board to ``timeout_s`` seconds, if the time-out can be set and is longer."""
        self._timeouts_s.append(timeout_s)

    @property
    def timeout_s(self) -> float:
        """The time-out in seconds: the board stops its motors after this time without a command."""
        return min(self._timeouts_s, default=self.default_timeout_s)

    @property
    def timeout_notice(self) -> str:
        return describe_timeout(self.timeout_s)

    @property
    def is_settled(self) -> bool:
        """Whether the newest command was sent."""
        return math.isinf(self.command.next_due)

    def begin(self, now: float) -> None:
        self._heard_at = -math.inf
        self._lose(now)

    def _lose_if_silent(self, now: float) -> None:
        if self.is_ready and now - self._heard_at > self.silence_s:
            self._lose(now)

    def _lose(self, now: float) -> None:
        """Drop the command: the board is lost, or was reset."""
        self.is_ready = False
        self.command.clear()

    def _set_ready(self) -> None:
        """Mark the board as ready, and drop the command, so that no motor turns before a new command."""
        self.command.clear()
        self.is_ready = True


def describe_timeout(timeout_s: float) -> str:
    """Return a sentence on the time-out of a board.

    >>> describe_timeout(0.5)
    'The board stops its motors by itself 0.5 s after the last command that it received.'
    """
    return f"The board stops its motors by itself {timeout_s:g} s after the last command that it received."


ProtocolT = TypeVar("ProtocolT", bound=Protocol)


class Board(Generic[ProtocolT]):
    """An open board: the line and the protocol that its devices share."""

    def __init__(self, line: Line, protocol: ProtocolT) -> None:
        self.line, self.protocol = line, protocol

    def __repr__(self) -> str:
        return f"Board({self.line!r}, {type(self.protocol).__name__})"

    def close(self) -> None:
        self.line.close()


class SharedBoardError(DeviceError):
    """The board of this device failed to open for another device; that device's error has the reason."""

    kind = "shared-board"


class _Attempt(Generic[ProtocolT]):
    """The result of opening a board. It is kept, so that other devices of a dead board fail without a wait."""

    def __init__(self, device: str, board: Board[ProtocolT] | None, failure: DeviceError | None = None) -> None:
        self.device, self.board, self.failure = device, board, failure

    def close(self) -> None:
        if self.board:
            self.board.close()


def open_board(
    device: str, place: str, kind: type[ProtocolT], make: Callable[[], ProtocolT], host: Host, answer_s: float
) -> Board[ProtocolT]:
    """Return the board on a port; open the port if this device is the first one of the board.

    device: the name of the device, for errors.
    place: the port in the robot's file.
    kind: the class of the board's protocol.
    make: returns a new protocol.
    answer_s: the longest wait for the board's first answer, in seconds.
    Raises DeviceError with the reason for the first device if the board cannot be opened, and SharedBoardError for all
    other devices of the board.
    """

    def attempt_to_open() -> _Attempt[ProtocolT]:
        protocol = make()
        line = Line(place, protocol, host.clock)
        try:
            line.open(device, answer_s)
        except DeviceError as failure:
            return _Attempt(device, None, failure)
        return _Attempt(device, Board(line, protocol))

    attempt = host.shared.take(_Attempt, (kind, place), attempt_to_open)
    if attempt.board:
        return attempt.board
    if attempt.failure and attempt.device == device:
        raise attempt.failure
    raise SharedBoardError(device, f"its board on {place} could not be opened for {attempt.device} either")
