"""One question at a time: answers carry no tag, so that one is only known by what was asked, and by its shape.

And which question is next: some are asked again and again, each as often as it is worth it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from drivers.serial.boards.rosarduino.protocol import GREETING_S, Answer, Parser, Question, checked

Heard = Callable[[Answer, float], None]
"""What is done with an answer, and the time at which it came."""


class Asking:
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
        self._asked: tuple[Question, Heard] | None = None
        self._asked_at = self._grace_s = 0.0

    @property
    def until(self) -> float | None:
        """When the question under way will be given up; None where there is none."""
        return self._asked_at + max(self._asked[0].patience_s, self._grace_s) if self._asked else None

    def ask(self, question: Question, heard: Heard, now: float) -> bytes:
        """Return what to send, and wait for the answer."""
        self._asked, self._asked_at = (question, heard), now
        return question.frame(is_summed=bool(self.is_summed))

    def hear(self, data: bytes, now: float) -> bool:
        """Take what has come in; return whether it answered the question under way."""
        answers = [self._hear(line, now) for line in self._parser.feed(data)]
        return any(answers)

    def waits(self, now: float) -> bool:
        """Return whether a question is under way; one that has waited too long is given up."""
        if self.until is not None and now >= self.until:
            self._grace_s = GREETING_S
            self.give_up()
        return self._asked is not None

    def drags(self, now: float, patience_s: float) -> bool:
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
    heard: Heard
    due: float = -math.inf


class Polls:
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
