"""Run a driver's exchanges with a server in a separate thread, where no signal interrupts them."""

from __future__ import annotations

from collections.abc import Callable
from queue import SimpleQueue
from threading import Lock, current_thread
from typing import Any, TypeVar

from robotcore.threads import start_thread

T = TypeVar("T")

CLOSING_S = 2.0
"""Time limit of `SerialExecutor.close`, in seconds, if a function hangs."""


class SerialExecutor:
    """Runs functions in its own thread, one after the other.

    A signal such as Ctrl-C raises an exception in the main thread. In the middle of an exchange with a server, the
    exception would break the connection, and the program could send no stop command. With an executor, the main
    thread only waits for the exchange. The exception ends this wait, and the exchange continues in the other thread.

    >>> executor = SerialExecutor("doctest")
    >>> executor.run(lambda: 6 * 7)
    42
    >>> executor.close()
    """

    def __init__(self, name: str) -> None:
        self._tasks = SimpleQueue[Callable[[], None] | None]()
        self._asking, self._is_closed = Lock(), False
        self._thread = start_thread(self._work, name)

    def run(self, work: Callable[[], T]) -> T:
        """Run a function in the executor's thread, and return its result or raise its exception.

        Any thread may call this method. After `close`, the function runs in the caller's thread.
        """
        done = SimpleQueue[tuple[Any, BaseException | None]]()
        if current_thread() is self._thread or not self._submit(lambda: done.put(_outcome_of(work))):
            return work()
        value, failure = done.get()
        if failure is not None:
            try:
                raise failure
            finally:
                del failure  # The traceback refers to this frame. This ends the cycle of references.
        result: T = value
        return result

    def close(self) -> None:
        """Wait for the submitted functions, at most `CLOSING_S`, and end the thread. A second call does nothing."""
        self._submit(None)
        self._thread.join(CLOSING_S)

    def _submit(self, task: Callable[[], None] | None) -> bool:
        """Add a task to the queue, and return whether the thread will run it. The task None ends the thread."""
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
    except BaseException as failure:  # noqa: BLE001  `run` raises it
        return None, failure
