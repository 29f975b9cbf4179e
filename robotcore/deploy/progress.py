"""Progress reports of an operation with several steps, such as a push."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class StepProgress:
    """The progress of a step.

    >>> print(StepProgress("doctor", "9 ok, 1 warning", ("warning: the disk is nearly full",), is_done=True))
      doctor       9 ok, 1 warning
        warning: the disk is nearly full
    """

    step: str
    """The name of the step."""
    text: str = ""
    """The result of a finished step, or the current activity of a running one."""
    details: tuple[str, ...] = ()
    """Further lines of the result, such as warnings."""
    is_done: bool = False
    """Whether the step is finished."""

    def __str__(self) -> str:
        """Return a line with the step's name and text, and a line for each detail."""
        return "\n".join((f"  {self.step:<13}{self.text}".rstrip(), *(f"    {detail}" for detail in self.details)))


ReportText = Callable[[str], object]
"""A function that is called with the current activity of a step, in words."""

OnStep = Callable[[StepProgress], object]
"""A function that is called when a step begins, at each update, and when the step is finished."""


@dataclass(frozen=True)
class StepReporter:
    """Reports the progress of one step."""

    name: str
    on_step: OnStep

    def update(self, text: str = "") -> None:
        """Report the current activity of the step."""
        self.on_step(StepProgress(self.name, text))

    def finish(self, text: str, *details: str) -> None:
        """Report the result of the step."""
        self.on_step(StepProgress(self.name, text, details, is_done=True))


def begin_step(name: str, on_step: OnStep) -> StepReporter:
    """Report that a step begins, and return its reporter."""
    step = StepReporter(name, on_step)
    step.update()
    return step
