"""The one place that composes a run: descriptions, backend, layers, loop."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence

from robotcore.runtime.execution import Execution
from robotcore.runtime.interrupts import Interrupts
from robotcore.runtime.layers.layer import Layer
from robotcore.runtime.observer import Observer, Run
from robotcore.runtime.outcome import RunResult
from robotcore.runtime.plan import Plan, RunRequest

__all__ = ["Observer", "Run", "RunRequest", "RunResult", "run"]


def _say(result: RunResult) -> None:
    """Say on standard error why the process ends; a stream of Python's may be held by what hangs."""
    os.write(2, f"error: {result.reason}\n".encode())


def run(
    request: RunRequest,
    observers: Sequence[Observer] = (),
    taps: Sequence[Layer] = (),
    *,
    last_words: Callable[[RunResult], object] = _say,
    patience: float = 1.0,
) -> RunResult:
    """Run an app and tell how it ended; ``taps`` are layers that see all that goes to the app and comes from it.

    Raises UsageError and BackendMissingError before anything is opened. What happens from then on is in the result,
    and every motor is stopped. An app or a driver that does not come back ends the process, where it cannot be
    interrupted: ``last_words`` is then called with the result, from another thread. Every limit on how long something
    may take is ``patience`` times as long.
    """
    plan = Plan.of(request)
    with Interrupts() as interrupts:
        return Execution(plan, observers, taps, interrupts, last_words, patience).result()
