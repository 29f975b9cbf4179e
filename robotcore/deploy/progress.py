"""The progress of a job with several steps, such as a push."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Progress:
    """The progress of a step.

    >>> print(Progress("doctor", "9 ok, 1 warning", ("warning: the disk is nearly full",), is_done=True))
      doctor       9 ok, 1 warning
        warning: the disk is nearly full
    """

    step: str
    """The name of the step."""
    text: str = ""
    """The result if the step ``is_done``, else what the step is doing."""
    notes: tuple[str, ...] = ()
    """Further results, a line each."""
    is_done: bool = False
    """Whether the step is finished."""

    def __str__(self) -> str:
        """Return the step and its text in one line, and the notes below it."""
        return "\n".join((f"  {self.step:<13}{self.text}".rstrip(), *(f"    {note}" for note in self.notes)))


Say = Callable[[str], object]
"""The type of a function that is called with a text on what a step is doing."""

OnStep = Callable[[Progress], object]
"""The type of a function that is called when a step begins, at each update, and when the step is finished."""


@dataclass(frozen=True)
class Step:
    """A step that has begun, with methods to report its progress."""

    name: str
    on_step: OnStep

    def update(self, text: str = "") -> None:
        """Report what the step is doing now."""
        self.on_step(Progress(self.name, text))

    def finish(self, text: str, *notes: str) -> None:
        """Report the result of the step."""
        self.on_step(Progress(self.name, text, notes, is_done=True))


def begin_step(name: str, on_step: OnStep) -> Step:
    """Report that a step begins, and return it."""
    step = Step(name, on_step)
    step.update()
    return step
