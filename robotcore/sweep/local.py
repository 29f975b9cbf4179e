"""The runs of a sweep on the cores of this machine."""

from __future__ import annotations

import os
import signal
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import TimeoutError as RunTimeoutError
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import get_context, resource_tracker

from robotcore.errors import BackendError, RobotcoreError
from robotcore.plan import RunRequest
from robotcore.sweep.engine import imported, patience
from robotcore.sweep.spec import Sweep
from robotcore.sweep.window import Future, completed
from robotcore.sweep.worker import Ended, perform_in_child, prepare_child, unfinished

_AHEAD = 2
"""Runs handed out for each worker, so that none waits for its next."""


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True)
class LocalEngine:
    """Runs in ``jobs`` processes of their own; a run that takes longer than ``wall_timeout_s`` is given up.

    Processes are spawned, not forked: no lock or thread of this process is copied in the middle of something.
    """

    jobs: int
    wall_timeout_s: float | None = None

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[Ended, None, None]:
        pebble = imported("pebble", "sweep")
        limit = patience(sweep.request, self.wall_timeout_s)
        pool = pebble.ProcessPool(self.jobs, initializer=prepare_child, context=get_context("spawn"))

        def submit(request: RunRequest) -> Future:
            with _holding_ctrl_c():  # the first one starts the workers
                future: Future = pool.schedule(perform_in_child, (request,), timeout=limit)
            return future

        try:
            for request, future in completed(submit, requests, lambda: _AHEAD * self.jobs):
                yield _ended(request, future, limit)
        finally:
            pool.stop()
            pool.join()


@contextmanager
def _holding_ctrl_c() -> Iterator[None]:
    """Let Ctrl-C wait, also in the threads and processes that start meanwhile and hand it on to theirs.

    A terminal sends it to everyone, and a worker that just starts would be loud about it. Workers hear it again once
    they are a group of their own (`prepare_child`).
    """
    resource_tracker.ensure_running()  # its start would let Ctrl-C through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _ended(request: RunRequest, future: Future, limit: float) -> Ended:
    from pebble import ProcessExpired

    try:
        ended: Ended = future.result()
    except BrokenProcessPool as error:
        raise BackendError(f"the worker processes die before they run anything: {error}") from error
    except ProcessExpired as error:
        return unfinished(request, BackendError(f"the worker process died: {_how(error.exitcode)}"))
    except RunTimeoutError:
        return unfinished(request, BackendError(f"hung: no end after {limit:g} s of wall time"))
    except Exception as error:  # noqa: BLE001  whatever a vendor's library raises costs this run alone
        return unfinished(request, RobotcoreError(f"{type(error).__name__}: {error}"))
    return ended


def _how(status: int) -> str:
    if status >= 0:
        return f"exit status {status}"
    with suppress(ValueError):  # a real-time signal has a number alone
        return signal.Signals(-status).name
    return f"signal {-status}"
