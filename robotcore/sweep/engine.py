"""The engine interface: what carries out the runs of a sweep, with a bounded number of tasks under way."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator
from importlib import import_module
from itertools import islice
from queue import Empty, SimpleQueue
from typing import Any, Protocol, TypeVar

from robotcore.errors import BackendMissingError
from robotcore.runtime.plan import RunRequest
from robotcore.sweep.single_run import RunOutput
from robotcore.sweep.spec import Sweep

HANG_FACTOR = 10.0
"""A run counts as hung after this many times its own time-out, plus a minute."""

TaskT = TypeVar("TaskT")

POLL_S = 1.0
"""Interval at which the allowed number of tasks is read again."""


class Engine(Protocol):
    """Carries out runs, in any order; closing the generator hands out no more of them."""

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[RunOutput, None, None]:
        """Yield each run as it ends. One that dies or hangs ends as an error; it keeps no other from running."""
        ...


def compute_hang_limit(request: RunRequest, asked_s: float | None) -> float:
    """Return after how many seconds of wall time a run counts as hung."""
    return 60.0 + HANG_FACTOR * request.timeout_s if asked_s is None else asked_s


def import_extra(module: str, extra: str) -> Any:
    """Return a module that an extra brings; BackendMissingError names the extra."""
    try:
        return import_module(module)
    except ImportError as error:
        raise BackendMissingError(
            f"the sweep needs {module}, which is not installed. pip install 'robotcore[{extra}]'",
            kind="library-missing",
            module=module,
            extra=extra,
        ) from error


class Future(Protocol):
    """The interface that the futures of executors share."""

    def add_done_callback(self, callback: Callable[[Any], Any], /) -> None: ...
    def result(self) -> Any: ...


def iterate_completed(
    submit: Callable[[TaskT], Future], tasks: Iterable[TaskT], width: Callable[[], int]
) -> Iterator[tuple[TaskT, Future]]:
    """Yield each task with its future as it ends; at most ``width()`` of them are under way.

    ``width`` is asked again whenever one has ended and every `POLL_S` seconds; what it raises ends the waiting.
    """
    ended: SimpleQueue[tuple[TaskT, Future]] = SimpleQueue()
    waiting, under_way = iter(tasks), 0

    def start(task: TaskT) -> None:
        submit(task).add_done_callback(lambda future: ended.put((task, future)))

    while True:
        for task in islice(waiting, max(width() - under_way, 0)):
            start(task)
            under_way += 1
        if not under_way:
            return
        try:
            done = ended.get(timeout=POLL_S)
        except Empty:
            continue
        under_way -= 1
        yield done
