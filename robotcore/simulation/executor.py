"""For drivers: work that no signal cuts in two, such as a question to a server and its answer."""

from __future__ import annotations

from collections.abc import Callable
from queue import SimpleQueue
from threading import Lock, current_thread
from typing import Any, TypeVar

from robotcore.threads import start_thread

T = TypeVar("T")

CLOSING_S = 2.0
"""Work that hangs does not keep its thread from being left for longer."""


class SerialExecutor:
    """Does work in one thread of its own, a piece at a time, in the order in which it is asked for.

    A signal (Ctrl-C, for one) raises where the program is. Half-way through an exchange with a server it would leave a
    line on which nothing can be said any more, not even that wheels are to stand. Here it interrupts who waits, while
    the work goes on; the next piece of work begins when that is done.

    >>> work = SerialExecutor("doctest")
    >>> work.run(lambda: 6 * 7)
    42
    >>> work.close()
    """

    def __init__(self, name: str) -> None:
        self._tasks = SimpleQueue[Callable[[], None] | None]()
        self._asking, self._is_closed = Lock(), False
        self._thread = start_thread(self._work, name)

    def run(self, work: Callable[[], T]) -> T:
        """Return what it returns, or raise what it raises. Any thread may ask; work may ask for more, done at once.

        After `close` whoever asks does it.
        """
        done = SimpleQueue[tuple[Any, BaseException | None]]()
        if current_thread() is self._thread or not self._submit(lambda: done.put(_outcome_of(work))):
            return work()
        value, failure = done.get()
        if failure is not None:
            try:
                raise failure
            finally:
                del failure  # its traceback holds this frame
        result: T = value
        return result

    def close(self) -> None:
        """Finish what was asked for, and end the thread. May be called again."""
        self._submit(None)
        self._thread.join(CLOSING_S)

    def _submit(self, task: Callable[[], None] | None) -> bool:
        """Ask for a task, None for the last; return whether there is a thread to do it."""
        with self._asking:
            if self._is_closed:
                return False
            self._is_closed = task is None
            self._tasks.put(task)
        return True

    def _work(self) -> None:
        while task := self._tasks.get():
            task()


def _outcome_of(work: Callable[[], T]) -> tuple[T | None, BaseException | None]:
    try:
        return work(), None
    except BaseException as failure:  # noqa: BLE001  raised where it is waited for
        return None, failure
