"""A motor board: the base class of its protocol, and the line that its devices share."""

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
    """A conversation with one board that answers, or tells by itself.

    A board that has told nothing for longer than `silence_s` is lost. What it was told is forgotten then, and once more
    when it is met again: a thread that was about to tell it something when it was lost turns no wheel later.
    """

    usual_timeout_s: ClassVar[float]
    """After how long without a command the board stops its motors by itself, where no motor asks for less."""

    def __init__(self, baud: int) -> None:
        self.baud, self.is_ready = baud, False
        self.command = CommandBuffer()
        self._timeouts_s: list[float] = []
        self._heard_at = -math.inf

    @property
    @abstractmethod
    def silence_s(self) -> float:
        """How long a board that is there tells nothing at most."""

    def limit(self, timeout_s: float) -> None:
        """Have the board stop by itself after so long, if it can be told; the shortest time counts."""
        self._timeouts_s.append(timeout_s)

    @property
    def timeout_s(self) -> float:
        """After how long without a command the board stops its motors by itself."""
        return min(self._timeouts_s, default=self.usual_timeout_s)

    @property
    def stops_itself(self) -> str:
        return stops_after(self.timeout_s)

    @property
    def is_settled(self) -> bool:
        """Whether the newest command has been sent."""
        return math.isinf(self.command.next_due)

    def begin(self, now: float) -> None:
        self._heard_at = -math.inf
        self._lose(now)

    def _lose_if_silent(self, now: float) -> None:
        if self.is_ready and now - self._heard_at > self.silence_s:
            self._lose(now)

    def _lose(self, now: float) -> None:
        """Know that the board is gone, or was reset."""
        self.is_ready = False
        self.command.clear()

    def _meet(self) -> None:
        """Know that the board is there; it stands until it is told anew."""
        self.command.clear()
        self.is_ready = True


def stops_after(timeout_s: float) -> str:
    """Say when a board stops by itself.

    >>> stops_after(0.5)
    'The board stops its motors by itself 0.5 s after the last command that it heard.'
    """
    return f"The board stops its motors by itself {timeout_s:g} s after the last command that it heard."


ProtocolT = TypeVar("ProtocolT", bound=Protocol)


class Board(Generic[ProtocolT]):
    """An open board: its line and its protocol, shared by its devices."""

    def __init__(self, line: Line, protocol: ProtocolT) -> None:
        self.line, self.protocol = line, protocol

    def close(self) -> None:
        self.line.close()


class SharedBoardError(DeviceError):
    """The board of this device failed to open for another device; that device's error has the reason."""

    kind = "shared-board"


class _Attempt(Generic[ProtocolT]):
    """The result of opening a board, so that later devices on a dead board do not wait again."""

    def __init__(self, device: str, board: Board[ProtocolT] | None, failure: DeviceError | None = None) -> None:
        self.device, self.board, self.failure = device, board, failure

    def close(self) -> None:
        if self.board:
            self.board.close()


def open_board(
    device: str, place: str, kind: type[ProtocolT], make: Callable[[], ProtocolT], host: Host, answer_s: float
) -> Board[ProtocolT]:
    """Return the board at a place; open it if this is the first of its devices.

    make: returns the board's protocol.
    answer_s: how long to wait for the first answer, in seconds.
    Raises DeviceError with the reason for the first device, and SharedBoardError for the others.
    """

    def attempted() -> _Attempt[ProtocolT]:
        protocol = make()
        line = Line(place, protocol, host.clock)
        try:
            line.open(device, answer_s)
        except DeviceError as failure:
            return _Attempt(device, None, failure)
        return _Attempt(device, Board(line, protocol))

    attempt = host.shared.take(_Attempt, (kind, place), attempted)
    if attempt.board:
        return attempt.board
    if attempt.failure and attempt.device == device:
        raise attempt.failure
    raise SharedBoardError(device, f"is on {place} too, which could not be opened for {attempt.device}")
