"""A motor board: a line, the conversation on it, and the devices that share both."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from drivers.serial.ports.line import Line
from drivers.serial.ports.talk import Talk
from robotcore.errors import DeviceError
from robotcore.hardware import Host

TalkT = TypeVar("TalkT", bound=Talk)


class Board(Generic[TalkT]):
    """What the devices of a board have in common; opened when the first asks for it, closed when all are closed."""

    def __init__(self, line: Line, talk: TalkT) -> None:
        self.line, self.talk = line, talk

    def close(self) -> None:
        self.line.close()


class AlsoOnItError(DeviceError):
    """A device is on a board that could not be opened for another one, which tells why."""


class _Attempt(Generic[TalkT]):
    """A board that was opened, or not: who comes later need not wait for it too."""

    def __init__(self, device: str, board: Board[TalkT] | None, failure: DeviceError | None = None) -> None:
        self.device, self.board, self.failure = device, board, failure

    def close(self) -> None:
        if self.board:
            self.board.close()


def open_board(
    device: str, place: str, kind: type[TalkT], make: Callable[[], TalkT], host: Host, answer_s: float
) -> Board[TalkT]:
    """Return the board at a place, opened if no device has asked for it; ``make`` makes its talk.

    It is waited ``answer_s`` seconds for the first answer. Raises DeviceError by the device's name; what is wrong is
    told by the device that asked first.
    """

    def attempted() -> _Attempt[TalkT]:
        talk = make()
        line = Line(place, talk, host.clock)
        try:
            line.open(device, answer_s)
        except DeviceError as failure:
            return _Attempt(device, None, failure)
        return _Attempt(device, Board(line, talk))

    attempt = host.shared.take(_Attempt, (kind, place), attempted)
    if attempt.board:
        return attempt.board
    if attempt.failure and attempt.device == device:
        raise attempt.failure
    raise AlsoOnItError(device, f"is on {place} too, which could not be opened for {attempt.device}")
