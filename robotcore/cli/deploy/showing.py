"""What goes on, step by step: what came of each stays, what goes on now is a line that moves in a terminal only."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import TYPE_CHECKING

from robotcore.cli.output import write_line
from robotcore.deploy.progress import Progress

if TYPE_CHECKING:
    from rich.live import Live
    from rich.spinner import Spinner


class Showing:
    """Shows what it is told. ``step`` is the one that was begun last.

    While a step has nothing to say, nothing moves: ssh may be asking for a password.
    """

    def __init__(self) -> None:
        self.step = ""
        self._live = _live() if sys.stderr and sys.stderr.isatty() else None

    def __call__(self, progress: Progress) -> None:
        self.step = progress.step
        if self._live and progress.said and not progress.is_done:
            self._live.update(_moving(progress))
            self._live.start()
        else:
            self.close()
        if progress.is_done:
            write_line(str(progress))

    def close(self) -> None:
        """Take the line that moves away. May be called again."""
        if self._live:
            self._live.stop()

    def __enter__(self) -> Showing:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()


def _live() -> Live:
    from rich.console import Console
    from rich.live import Live

    return Live(console=Console(stderr=True, highlight=False, markup=False), transient=True)


def _moving(progress: Progress) -> Spinner:
    from rich.spinner import Spinner
    from rich.text import Text

    return Spinner("dots", Text(f"{progress.step:<13}{progress.said}"))  # of a string, rich would obey its markup
