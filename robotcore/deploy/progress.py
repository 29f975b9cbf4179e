"""The progress of a long job, step by step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Progress:
    """A step by its name, and what there is to say of it: what goes on, or, where it ``is_done``, what came of it.

    ``notes`` are what its reader should know besides, a line each.
    """

    step: str
    text: str = ""
    notes: tuple[str, ...] = ()
    is_done: bool = False

    def __str__(self) -> str:
        """Return it in a line, its notes below.

        >>> print(Progress("doctor", "9 ok, 1 warning", ("warning: the disk is nearly full",), is_done=True))
          doctor       9 ok, 1 warning
            warning: the disk is nearly full
        """
        return "\n".join((f"  {self.step:<13}{self.text}".rstrip(), *(f"    {note}" for note in self.notes)))


Say = Callable[[str], object]
"""Is called with a text on what a step is doing."""

OnStep = Callable[[Progress], object]
"""Is called when a step begins, at each update, and when it is finished."""


@dataclass(frozen=True)
class Step:
    """A step that has begun."""

    name: str
    on_step: OnStep

    def update(self, text: str = "") -> None:
        """Report what the step is doing."""
        self.on_step(Progress(self.name, text))

    def finish(self, text: str, *notes: str) -> None:
        """Report the result of the step."""
        self.on_step(Progress(self.name, text, notes, is_done=True))


def begin_step(name: str, on_step: OnStep) -> Step:
    """Report that a step begins, and return it."""
    step = Step(name, on_step)
    step.update()
    return step
