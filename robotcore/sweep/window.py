"""Many tasks through an executor, only as many at once as keep it busy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from queue import Empty, SimpleQueue
from typing import Any, Protocol, TypeVar

TaskT = TypeVar("TaskT")

LOOK_S = 1.0
"""So often somebody looks how many tasks there may be now."""


class Future(Protocol):
    """What the futures of executors have in common."""

    def add_done_callback(self, callback: Callable[[Any], Any], /) -> None: ...
    def result(self) -> Any: ...


def completed(
    submit: Callable[[TaskT], Future], tasks: Iterable[TaskT], width: Callable[[], int]
) -> Iterator[tuple[TaskT, Future]]:
    """Yield each task with its future as it ends; at most ``width()`` of them are under way.

    ``width`` is asked again whenever one has ended and every `LOOK_S` seconds; what it raises ends the waiting.
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
            done = ended.get(timeout=LOOK_S)
        except Empty:
            continue
        under_way -= 1
        yield done
