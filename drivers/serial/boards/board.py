"""The base class of the protocols of motor boards, and the opening of a board that several devices share."""

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
    """The base class of the protocols of boards that send data, on request or periodically.

    A board that has sent nothing for longer than `silence_s` is lost. The protocol drops the command when the board is
    lost, and again when the board sends data again. So a command that was set during the loss never turns a wheel.
    """

    default_timeout_s: ClassVar[float]
    """The board stops its motors after this many seconds without a command, unless `limit` sets a shorter time."""

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


def describe_timeout(timeout_s: float) -> str:
    """Return the sentence for messages and notes that describes the time-out of a board.

    >>> describe_timeout(0.5)
    'The board stops its motors by itself 0.5 s after the last command that it received.'
    """
    return f"The board stops its motors by itself {timeout_s:g} s after the last command that it received."


ProtocolT = TypeVar("ProtocolT", bound=Protocol)


class Board(Generic[ProtocolT]):
    """An open board: its line and its protocol, which all its devices share."""

    def __init__(self, line: Line, protocol: ProtocolT) -> None:
        self.line, self.protocol = line, protocol

    def __repr__(self) -> str:
        return f"Board({self.line!r}, {type(self.protocol).__name__})"

    def close(self) -> None:
        self.line.close()


class SharedBoardError(DeviceError):
    """A device cannot be opened, because opening its board already failed for another device.

    The DeviceError of that other device has the reason.
    """

    kind = "shared-board"


class _OpeningResult(Generic[ProtocolT]):
    """The result of opening a board. With it, further devices of a dead board fail without a second wait."""

    def __init__(self, device: str, board: Board[ProtocolT] | None, failure: DeviceError | None = None) -> None:
        self.device, self.board, self.failure = device, board, failure

    def close(self) -> None:
        if self.board:
            self.board.close()


def open_board(
    device: str, place: str, kind: type[ProtocolT], make: Callable[[], ProtocolT], host: Host, answer_s: float
) -> Board[ProtocolT]:
    """Return the board on a port; open the port if this device is the first one of the board.

    If the board cannot be opened, the first device gets a DeviceError with the reason. All other devices of the board
    get a SharedBoardError.

    device: the name of the device, for errors.
    place: the port in the robot's file.
    kind: the class of the board's protocol.
    make: returns a new protocol.
    answer_s: the longest wait for the board's first data, in seconds.
    """

    def open_once() -> _OpeningResult[ProtocolT]:
        protocol = make()
        line = Line(place, protocol, host.clock)
        try:
            line.open(device, answer_s)
        except DeviceError as failure:
            return _OpeningResult(device, None, failure)
        return _OpeningResult(device, Board(line, protocol))

    result = host.shared.take(_OpeningResult, (kind, place), open_once)
    if result.board:
        return result.board
    if result.failure and result.device == device:
        raise result.failure
    raise SharedBoardError(device, f"its board on {place} could not be opened; see the error of {result.device}")
