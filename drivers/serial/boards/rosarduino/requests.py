"""Send requests to an Arduino, one at a time because answers do not contain their question, and detect its firmware."""

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
    duties,
    identity_question,
    remove_sum,
)

AnswerHandler = Callable[[Answer, float], None]
"""A function that takes an answer and its time of arrival in seconds."""


class RequestQueue:
    """Sends one question at a time, and passes its answer to a handler. All other lines are dropped.

    The answer to a question that timed out may still arrive, and look like the answer to the next question. So the next
    question must be one whose answer no other question has (`Question.raw`). After a time-out the board may be slow.
    Then the time-out of each question is at least `GREETING_S`, until an answer arrives in time.
    """

    def __init__(self) -> None:
        self.is_summed: bool | None = None
        """Whether every answer has a checksum; None until the firmware is known."""
        self.is_sure = True
        """Whether it is certain that no answer to an earlier question can arrive."""
        self._parser = Parser()
        self._asked: tuple[Question, AnswerHandler] | None = None
        self._asked_at = self._grace_s = 0.0

    @property
    def until(self) -> float | None:
        """The time at which the pending question times out; None if no question is pending."""
        return self._asked_at + max(self._asked[0].timeout_s, self._grace_s) if self._asked else None

    def ask(self, question: Question, on_answer: AnswerHandler, now: float) -> bytes:
        """Make ``question`` the pending one, and return the bytes to send.

        on_answer: is called with the answer and its time.
        """
        self._asked, self._asked_at = (question, on_answer), now
        return question.frame(is_summed=bool(self.is_summed))

    def receive(self, data: bytes, now: float) -> bool:
        """Parse received bytes; return whether they answered the pending question."""
        answers = [self._take_line(line, now) for line in self._parser.feed(data)]
        return any(answers)

    def is_waiting(self, now: float) -> bool:
        """Return whether a question is pending; drop it if it has timed out."""
        if self.until is not None and now >= self.until:
            self._grace_s = GREETING_S
            self.give_up()
        return self._asked is not None

    def is_overdue(self, now: float, timeout_s: float) -> bool:
        """Return whether a question has been pending for longer than ``timeout_s``."""
        return self._asked is not None and now - self._asked_at > timeout_s

    def give_up(self) -> None:
        """Drop the pending question, whose answer may still arrive."""
        self._asked, self.is_sure = None, False

    def interrupt(self) -> None:
        """Drop the pending question, because other data was sent, unless no other question has its answer."""
        if self._asked and not self._asked[0].raw:
            self.give_up()

    def _take_line(self, line: str, now: float) -> bool:
        text = self._remove_sum(line)
        if self._asked is None or text is None:
            return False
        question, on_answer = self._asked
        if (answer := question.answer(text)) is None:
            return False
        self._asked = None
        self.is_sure = self.is_sure or bool(question.raw)
        if not question.raw and now - self._asked_at <= question.timeout_s:
            self._grace_s = 0.0
        on_answer(answer, now)
        return True

    def _remove_sum(self, line: str) -> str | None:
        """Return a line without its checksum; None if the checksum is wrong or is missing.

        If `is_summed` is not true, a line without a checksum is returned as it is.
        """
        if self.is_summed is None:
            return remove_sum(line) or line
        return remove_sum(line) if self.is_summed else line


@dataclass
class Poll:
    """A question that is asked periodically, and the handler of its answers."""

    question: Question
    period_s: float
    on_answer: AnswerHandler
    due: float = -math.inf
    """The time at which the question is asked next, in seconds."""


class PollSchedule:
    """Selects the poll that has been due for the longest time, so that frequent polls do not block rare ones."""

    def __init__(self, *polls: Poll) -> None:
        self._polls = polls

    def add(self, poll: Poll) -> None:
        """Add a poll. Another thread may call `take` at the same time."""
        self._polls = (*self._polls, poll)

    def take(self, now: float) -> Poll | None:
        """Return the poll to ask now; None if none is due."""
        poll = min(self._polls, key=lambda poll: poll.due)
        if now < poll.due:
            return None
        poll.due = now + poll.period_s
        return poll

    @property
    def next_due(self) -> float:
        """The time from which `take` returns a poll."""
        return min(poll.due for poll in self._polls)

    @property
    def slowest_s(self) -> float:
        """The longest time-out of the polls' questions, in seconds."""
        return max(poll.question.timeout_s for poll in self._polls)


VERSION = 1
"""The version of robotcore_bridge's protocol that this driver supports."""


@dataclass(frozen=True)
class Firmware:
    """The firmware of a board and its abilities, as found by its answers."""

    is_robotcore_bridge: bool
    """Whether the firmware is robotcore_bridge."""
    frame_s: float
    """The duration of a frame in seconds; speeds are in counts a frame."""
    has_wheels: bool = True
    takes_duties: bool = True
    fault: str = ""
    """Why this driver does not support the firmware, and the remedy; empty if it is supported."""


UNKNOWN = Firmware(is_robotcore_bridge=False, frame_s=1 / 30, has_wheels=False, takes_duties=False)
"""The value for a board whose firmware is not known yet."""

_Probe: TypeAlias = Generator[Question, Answer, Firmware]
"""A generator that yields questions, gets the answer to each, and returns the firmware."""


class FirmwareProbe:
    """Detects the firmware of a board by a series of questions. The first question stops the motors."""

    def __init__(self, baud: int) -> None:
        self._baud = baud
        self._meeting: _Probe | None = None
        self._next: Question | None = None

    def question(self) -> Question:
        """Return the next question. If the last question was not answered, start again with the first one."""
        question, self._next = self._next, None
        if question is None:
            self._meeting = _probe(self._baud)
            question = next(self._meeting)
        return question

    def take(self, answer: Answer) -> Firmware | None:
        """Process the answer to the last question; return the firmware if it is known now."""
        assert self._meeting
        try:
            self._next = self._meeting.send(answer)
        except StopIteration as end:
            return cast("Firmware", end.value)
        return None


def _probe(baud: int) -> _Probe:
    """Yield the questions that detect the firmware, and return the firmware.

    A board that answers twice with its baud rate runs ROSArduinoBridge. One such answer is not enough, because noise
    may have destroyed the part of the question to which robotcore_bridge answers with its version.
    """
    for _ in range(2):
        number = (yield identity_question(baud)).numbers[0]
        if number != baud:
            return _describe_robotcore_bridge(number)
    has_wheels = yield from _ask_twice(STOP)
    takes_duties = has_wheels and (yield from _ask_twice(duties(0, 0)))
    # A frame of the firmware has a whole number of milliseconds, 33.
    return Firmware(is_robotcore_bridge=False, frame_s=0.033, has_wheels=has_wheels, takes_duties=takes_duties)


def _ask_twice(question: Question) -> Generator[Question, Answer, bool]:
    """Return whether the board accepts a command. Send it again after a refusal, which noise may have caused."""
    for _ in range(2):
        if not (yield question).is_refusal:
            return True
    return False


def _describe_robotcore_bridge(version: int) -> Firmware:
    fault = (
        ""
        if version == VERSION
        else f"its firmware has version {version} of the protocol, and this robotcore supports {VERSION}; flash the "
        "firmware of this robotcore: robotcore firmware flash"
    )
    return Firmware(is_robotcore_bridge=True, frame_s=1 / 30, fault=fault)
