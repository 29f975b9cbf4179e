"""What is asked again and again, each as often as it is worth it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from drivers.serial.boards.rosarduino.asking import Heard
from drivers.serial.boards.rosarduino.protocol import Question


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
