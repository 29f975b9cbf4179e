"""Which firmware a board runs, and what follows from it."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import TypeAlias, cast

from drivers.serial.boards.rosarduino.protocol import STOP, Answer, Question, duties, who_is_there

VERSION = 1
"""What our firmware speaks that this driver knows."""


@dataclass(frozen=True)
class Firmware:
    """What a board told of itself.

    Speeds are counts in a frame of ``frame_s`` seconds. ``fault`` says, with what to do, why it cannot be worked with.
    """

    is_ours: bool
    frame_s: float
    has_wheels: bool = True
    takes_duties: bool = True
    fault: str = ""


UNKNOWN = Firmware(is_ours=False, frame_s=1 / 30, has_wheels=False, takes_duties=False)
"""Before a board has told anything."""

_Meeting: TypeAlias = Generator[Question, Answer, Firmware]
"""Questions, each after the answer to the one before; at the end it is known who answers."""


class Acquaintance:
    """Finds out who answers; the motors stand from the first question on."""

    def __init__(self, baud: int) -> None:
        self._baud = baud
        self._meeting: _Meeting | None = None
        self._next: Question | None = None

    def question(self) -> Question:
        """Return what is to be asked next; the first question again, where the last one was not answered."""
        question, self._next = self._next, None
        if question is None:
            self._meeting = _met(self._baud)
            question = next(self._meeting)
        return question

    def answered(self, answer: Answer) -> Firmware | None:
        """Take the answer to the last question; return the firmware once it is known."""
        assert self._meeting
        try:
            self._next = self._meeting.send(answer)
        except StopIteration as end:
            return cast("Firmware", end.value)
        return None


def _met(baud: int) -> _Meeting:
    """Ask who answers.

    The true one is who twice says nothing but its speed: once, noise may have spoilt the question that ours answers.
    """
    for _ in range(2):
        told = (yield who_is_there(baud)).numbers[0]
        if told != baud:
            return _ours(told)
    has_wheels = yield from _understands(STOP)
    takes_duties = has_wheels and (yield from _understands(duties(0, 0)))
    # It counts whole milliseconds, so that its 30 frames a second are 30.3.
    return Firmware(is_ours=False, frame_s=0.033, has_wheels=has_wheels, takes_duties=takes_duties)


def _understands(question: Question) -> Generator[Question, Answer, bool]:
    """Ask twice where it is refused, for noise may have been."""
    for _ in range(2):
        if not (yield question).is_refusal:
            return True
    return False


def _ours(version: int) -> Firmware:
    fault = (
        ""
        if version == VERSION
        else f"its firmware speaks version {version}, and this robotcore {VERSION}; flash the one that came with it: "
        "robotcore firmware flash"
    )
    return Firmware(is_ours=True, frame_s=1 / 30, fault=fault)
