"""The interface of engines, which execute the runs of a sweep, and a loop that limits the unfinished tasks."""

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
"""The factor of the hang limit. A run counts as hung after its time limit times this factor, plus a minute."""

TaskT = TypeVar("TaskT")

POLL_S = 1.0
"""The interval in seconds at which `iterate_completed` calls ``count_allowed``."""


class Engine(Protocol):
    """Executes the runs of a sweep, in any order."""

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[RunOutput, None, None]:
        """Execute runs of a sweep, and yield the output of each run when it ends.

        If the process of a run dies or hangs, that run has the outcome ``error``, and the other runs continue.
        Closing the generator stops the unfinished runs.
        """
        ...


def compute_hang_limit(request: RunRequest, wall_timeout_s: float | None) -> float:
    """Return the seconds of wall time after which a run counts as hung.

    wall_timeout_s: the limit that the user chose, in seconds. None means `HANG_FACTOR` times the run's time limit,
        plus a minute.
    """
    return 60.0 + HANG_FACTOR * request.timeout_s if wall_timeout_s is None else wall_timeout_s


def import_extra(module: str, extra: str) -> Any:
    """Import and return a module. Raises BackendMissingError, with the command that installs it, if it is missing.

    extra: the extra of robotcore that installs the module, such as ``cluster``.
    """
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
    """The methods that a future of `concurrent.futures` and a future of Dask have in common."""

    def add_done_callback(self, callback: Callable[[Any], Any], /) -> None: ...
    def result(self) -> Any: ...


def iterate_completed(
    submit: Callable[[TaskT], Future], tasks: Iterable[TaskT], count_allowed: Callable[[], int]
) -> Iterator[tuple[TaskT, Future]]:
    """Submit tasks, and yield each task with its future when the task ends.

    submit: a function that starts a task and returns its future.
    tasks: the tasks. They are submitted in this order.
    count_allowed: a function that returns how many tasks may be unfinished at a time. It is called after each end of a
        task, and at least every `POLL_S` seconds. Its exceptions end the iteration.
    """
    ended: SimpleQueue[tuple[TaskT, Future]] = SimpleQueue()
    waiting, unfinished = iter(tasks), 0

    def start(task: TaskT) -> None:
        submit(task).add_done_callback(lambda future: ended.put((task, future)))

    while True:
        for task in islice(waiting, max(count_allowed() - unfinished, 0)):
            start(task)
            unfinished += 1
        if not unfinished:
            return
        try:
            done = ended.get(timeout=POLL_S)
        except Empty:
            continue
        unfinished -= 1
        yield done
