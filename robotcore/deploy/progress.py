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


OnStep = Callable[[StepProgress], object]
"""A function that is called when a step begins, at each update, and when the step is finished."""

OnText = Callable[[str], object]
"""A function that is called with the current activity of a step, in words."""


class Step:
    """Reports the progress of one step. The constructor reports that the step begins."""

    def __init__(self, name: str, on_step: OnStep) -> None:
        self._name, self._on_step = name, on_step
        self.update()

    def update(self, text: str = "") -> None:
        """Report the current activity of the step."""
        self._on_step(StepProgress(self._name, text))

    def finish(self, text: str, *details: str) -> None:
        """Report the result of the step."""
        self._on_step(StepProgress(self._name, text, details, is_done=True))
