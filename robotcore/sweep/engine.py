"""The interface of engines, which execute the runs of a sweep, and a loop that limits the number of running tasks."""

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
"""A run counts as hung after this many times its own time limit, plus a minute."""

TaskT = TypeVar("TaskT")

POLL_S = 1.0
"""The interval in seconds at which `iterate_completed` asks how many tasks may run."""


class Engine(Protocol):
    """Executes runs, in any order."""

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[RunOutput, None, None]:
        """Execute runs of a sweep, and yield the output of each run when it ends.

        Closing the generator stops the unfinished runs.
        A run that dies or hangs has the outcome ``error``. The other runs go on.
        """
        ...


def compute_hang_limit(request: RunRequest, wall_timeout_s: float | None) -> float:
    """Return the seconds of wall time after which a run counts as hung.

    wall_timeout_s: the value to return; None for ten times the run's own time limit and a minute.
    """
    return 60.0 + HANG_FACTOR * request.timeout_s if wall_timeout_s is None else wall_timeout_s


def import_extra(module: str, extra: str) -> Any:
    """Return a module that an extra of robotcore installs. Raises BackendMissingError if it is not installed."""
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
    """The methods that the futures of `concurrent.futures` and of Dask share."""

    def add_done_callback(self, callback: Callable[[Any], Any], /) -> None: ...
    def result(self) -> Any: ...


def iterate_completed(
    submit: Callable[[TaskT], Future], tasks: Iterable[TaskT], width: Callable[[], int]
) -> Iterator[tuple[TaskT, Future]]:
    """Submit tasks. When a task ends, yield the task and its future.

    submit: starts a task.
    tasks: the tasks.
    width: returns the number of tasks that may run at a time. It is called whenever a task ends, and every `POLL_S`
        seconds. Its exceptions are raised.
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
