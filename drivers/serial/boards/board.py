"""A motor board: a line, the conversation on it, and the devices that share both."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

from drivers.serial.ports.line import Line
from drivers.serial.ports.talk import Talk
from robotcore.hardware import Host

TalkT = TypeVar("TalkT", bound=Talk)


class Board(Generic[TalkT]):
    """What the devices of a board have in common; opened when the first asks for it, closed when all are closed."""

    def __init__(self, line: Line, talk: TalkT) -> None:
        self.line, self.talk = line, talk

    def close(self) -> None:
        self.line.close()


def open_board(
    device: str, place: str, kind: type[TalkT], make: Callable[[], TalkT], host: Host, answer_s: float
) -> Board[TalkT]:
    """Return the board at a place, opened if no device has asked for it; ``make`` makes its talk.

    It is waited ``answer_s`` seconds for the first answer. Raises DeviceError by the device's name.
    """

    def opened() -> Board[TalkT]:
        talk = make()
        line = Line(place, talk, host.clock)
        line.open(device, answer_s)
        return Board(line, talk)

    return host.shared.take(Board, (kind, place), opened)
