"""What carries out the runs of a sweep, wherever it does."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from importlib import import_module
from typing import Any, Protocol

from robotcore.errors import BackendMissingError
from robotcore.runtime.plan import RunRequest
from robotcore.sweep.spec import Sweep
from robotcore.sweep.worker import Ended

PATIENCE = 10.0
"""A run may take so many times as long as its own time-out before it counts as hung, and a minute more."""


class Engine(Protocol):
    """Carries out runs, in any order; closing the generator hands out no more of them."""

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[Ended, None, None]:
        """Yield each run as it ends. One that dies or hangs ends as an error; it keeps no other from running."""
        ...


def patience(request: RunRequest, asked_s: float | None) -> float:
    """Return after how many seconds of wall time a run counts as hung."""
    return 60.0 + PATIENCE * request.timeout_s if asked_s is None else asked_s


def imported(module: str, extra: str) -> Any:
    """Return a module that an extra brings; BackendMissingError names the extra."""
    try:
        return import_module(module)
    except ImportError as error:
        raise BackendMissingError(
            f"the sweep needs {module}, which is not installed. pip install 'robotcore[{extra}]'"
        ) from error
