"""Requests to a board, one at a time, because answers carry no tag; and the probe of its firmware."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TypeAlias, cast

from drivers.serial.boards.rosarduino.protocol import (
    GREETING_S,
    STOP,
    Answer,
    Parser,
    Question,
    checked,
    duties,
    who_is_there,
)

AnswerHandler = Callable[[Answer, float], None]
"""What is done with an answer, and the time at which it came."""


class RequestQueue:
    """Asks, and hands each answer to whoever asked; what is no answer to the question under way is dropped.

    A question that is given up leaves a doubt: its answer may yet come. Until a question whose answer has a shape of
    its own was answered, no other should be asked. From then on `GREETING_S` is waited for every answer, until one
    comes as soon as it should: a board may be slow, and is to be heard all the same.
    """

    def __init__(self) -> None:
        self.is_summed: bool | None = None
        """Whether every answer has a sum; None where it is not known yet."""
        self.is_sure = True
        """Whether nothing that comes in can be the answer to a question that was given up."""
        self._parser = Parser()
        self._asked: tuple[Question, AnswerHandler] | None = None
        self._asked_at = self._grace_s = 0.0

    @property
    def until(self) -> float | None:
        """When the question under way will be given up; None where there is none."""
        return self._asked_at + max(self._asked[0].patience_s, self._grace_s) if self._asked else None

    def ask(self, question: Question, heard: AnswerHandler, now: float) -> bytes:
        """Return what to send, and wait for the answer."""
        self._asked, self._asked_at = (question, heard), now
        return question.frame(is_summed=bool(self.is_summed))

    def receive(self, data: bytes, now: float) -> bool:
        """Take what has come in; return whether it answered the question under way."""
        answers = [self._hear(line, now) for line in self._parser.feed(data)]
        return any(answers)

    def is_waiting(self, now: float) -> bool:
        """Return whether a question is under way; one that has waited too long is given up."""
        if self.until is not None and now >= self.until:
            self._grace_s = GREETING_S
            self.give_up()
        return self._asked is not None

    def is_overdue(self, now: float, patience_s: float) -> bool:
        """Return whether the question under way has waited for longer than that."""
        return self._asked is not None and now - self._asked_at > patience_s

    def give_up(self) -> None:
        """Wait no longer for the answer, which may come yet."""
        self._asked, self.is_sure = None, False

    def interrupt(self) -> None:
        """Know that something else was sent: two answers may come. One that ends doubts is known all the same."""
        if self._asked and not self._asked[0].raw:
            self.give_up()

    def _hear(self, line: str, now: float) -> bool:
        text = self._text_of(line)
        if self._asked is None or text is None:
            return False
        question, heard = self._asked
        if (answer := question.answer(text)) is None:
            return False
        self._asked = None
        self.is_sure = self.is_sure or bool(question.raw)
        if not question.raw and now - self._asked_at <= question.patience_s:
            self._grace_s = 0.0
        heard(answer, now)
        return True

    def _text_of(self, line: str) -> str | None:
        """Return a line without its sum, None where that is wrong, or missing where every answer has one."""
        if self.is_summed is None:
            return checked(line) or line
        return checked(line) if self.is_summed else line


@dataclass
class Poll:
    """A question that is asked again and again, and what is done with the answers."""

    question: Question
    period_s: float
    heard: AnswerHandler
    due: float = -math.inf


class PollSchedule:
    """Takes turns: what has been due for longest comes first, so that nothing frequent keeps off what is rare."""

    def __init__(self, *polls: Poll) -> None:
        self._polls = polls

    def add(self, poll: Poll) -> None:
        """Ask something else too; another thread may be taking turns meanwhile."""
        self._polls = (*self._polls, poll)

    def take(self, now: float) -> Poll | None:
        """Return what is to be asked now."""
        poll = min(self._polls, key=lambda poll: poll.due)
        if now < poll.due:
            return None
        poll.due = now + poll.period_s
        return poll

    @property
    def next_due(self) -> float:
        """When `take` has something."""
        return min(poll.due for poll in self._polls)

    @property
    def slowest_s(self) -> float:
        """How long the slowest answer may take, in seconds."""
        return max(poll.question.patience_s for poll in self._polls)


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

_Probe: TypeAlias = Generator[Question, Answer, Firmware]
"""Questions, each after the answer to the one before; at the end it is known who answers."""


class FirmwareProbe:
    """Finds out who answers; the motors stand from the first question on."""

    def __init__(self, baud: int) -> None:
        self._baud = baud
        self._meeting: _Probe | None = None
        self._next: Question | None = None

    def question(self) -> Question:
        """Return what is to be asked next; the first question again, where the last one was not answered."""
        question, self._next = self._next, None
        if question is None:
            self._meeting = _probe(self._baud)
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


def _probe(baud: int) -> _Probe:
    """Ask who answers.

    The true one is who twice says nothing but its speed: once, noise may have spoilt the question that ours answers.
    """
    for _ in range(2):
        number = (yield who_is_there(baud)).numbers[0]
        if number != baud:
            return _ours(number)
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
