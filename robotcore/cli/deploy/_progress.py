"""Displays the steps of a push."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import TYPE_CHECKING

from robotcore.cli.output import write_lines
from robotcore.deploy.progress import StepProgress

if TYPE_CHECKING:
    from rich.live import Live
    from rich.spinner import Spinner


class StepDisplay:
    """Prints each finished step. If stderr is a terminal, a spinner shows the running step.

    The spinner starts with the first update of a step, because ssh may ask for a password before that.
    """

    def __init__(self) -> None:
        self.step = ""
        """The name of the newest step."""
        self._live = _make_live() if sys.stderr and sys.stderr.isatty() else None

    def __call__(self, progress: StepProgress) -> None:
        self.step = progress.step
        if self._live and progress.text and not progress.is_done:
            self._live.update(_make_spinner(progress))
            self._live.start()
        else:
            self.close()
        if progress.is_done:
            write_lines(str(progress))

    def close(self) -> None:
        """Remove the spinner. The method may be called again."""
        if self._live:
            self._live.stop()

    def __enter__(self) -> StepDisplay:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()


def _make_live() -> Live:
    from rich.console import Console
    from rich.live import Live

    return Live(console=Console(stderr=True, highlight=False, markup=False), transient=True)


def _make_spinner(progress: StepProgress) -> Spinner:
    from rich.spinner import Spinner
    from rich.text import Text

    # in a plain string, rich would interpret square brackets as markup
    return Spinner("dots", Text(f"{progress.step:<13}{progress.text}"))
