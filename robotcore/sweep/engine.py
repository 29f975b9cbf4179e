"""Run a sweep. Engines execute its runs: their interface, and the engine for the cores of this machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable
from contextlib import ExitStack, closing
from dataclasses import dataclass
from multiprocessing.pool import ThreadPool
from pathlib import Path
from queue import SimpleQueue
from threading import Semaphore
from typing import Protocol

from robotcore.runtime.plan import RunRequest
from robotcore.sweep.preflight import preflight
from robotcore.sweep.record import Record
from robotcore.sweep.results import Results
from robotcore.sweep.single_run import RunOutput, attempt
from robotcore.sweep.spec import Sweep
from robotcore.sweep.worker import WorkerProcess

HANG_FACTOR = 10.0
"""The factor of the hang limit. A run counts as hung after its time limit times this factor, plus a minute."""


class Engine(Protocol):
    """Executes the runs of a sweep, in any order."""

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[RunOutput, None, None]:
        """Execute runs of a sweep, and yield the output of each run when it ends.

        If the process of a run dies or hangs, that run has the outcome ``error``, and the other runs continue.
        Closing the generator stops the unfinished runs.
        """
        ...


def run_sweep(
    sweep: Sweep,
    engine: Engine | None = None,
    directory: Path | None = None,
    *,
    deletes_old_results: bool = False,
) -> Results:
    """Execute the runs of a sweep that its folder does not have yet, and return the results. `Results` has an example.

    sweep: the sweep.
    engine: the engine. None means a `LocalEngine` on all cores.
    directory: the folder of the results. None means ``sweeps/<app>-<digest>``.
    deletes_old_results: whether to delete all results in the folder first.

    Raises the errors of `preflight` before the first run.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest
    >>> from robotcore.sweep import LocalEngine, Sweep
    >>> sweep = Sweep(RunRequest("avoid-obstacles", settings={"duration_s": 0.2}), worlds=("open",), seeds=(1,))
    >>> with TemporaryDirectory() as folder:
    ...     results = run_sweep(sweep, LocalEngine(jobs=1), Path(folder))
    ...     [record.result.outcome.value for record in results.records()]
    ['success']
    """
    preflight(sweep)
    with Results(sweep, directory, deletes_old_results=deletes_old_results) as results:
        execute(results, engine or LocalEngine(count_cores()))
    return results


def execute(results: Results, engine: Engine, on_record: Callable[[Record], None] = lambda _: None) -> None:
    """Execute the runs without a record, and write their records and the tables. Writes the tables even after an error.

    on_record: a function that is called with each new record.
    """
    try:
        if missing := results.missing():
            with closing(engine.perform(results.sweep, missing)) as outputs:
                for output in outputs:
                    on_record(results.add(output))
    finally:
        results.write_tables()


def count_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def compute_hang_limit(request: RunRequest, wall_timeout_s: float | None) -> float:
    """Return the seconds of wall time after which a run counts as hung.

    wall_timeout_s: the limit that the user chose, in seconds. None means `HANG_FACTOR` times the run's time limit,
        plus a minute.
    """
    return 60.0 + HANG_FACTOR * request.timeout_s if wall_timeout_s is None else wall_timeout_s


@dataclass(frozen=True)
class LocalEngine:
    """Executes runs in worker processes on this machine.

    >>> LocalEngine(jobs=2, wall_timeout_s=600.0)
    LocalEngine(jobs=2, wall_timeout_s=600.0)
    """

    jobs: int
    """The number of worker processes."""

    wall_timeout_s: float | None = None
    """The seconds of wall time after which a run counts as hung. None means ten times its time limit, plus a minute."""

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[RunOutput, None, None]:
        limit = compute_hang_limit(sweep.request, self.wall_timeout_s)
        workers = [WorkerProcess() for _ in range(self.jobs)]
        idle: SimpleQueue[WorkerProcess] = SimpleQueue()
        unconsumed = Semaphore(2 * self.jobs)  # limits the outputs that wait in memory for a slow disk

        def attempt_in_worker(request: RunRequest) -> RunOutput:
            unconsumed.acquire()
            worker = idle.get()
            try:
                return attempt(worker, request, limit)
            finally:
                idle.put(worker)

        with ExitStack() as stack:  # on exit: start no run, kill the processes, await the threads, close the pipes
            threads = ThreadPool(self.jobs)
            for worker in workers:
                idle.put(worker)
                stack.callback(worker.close)
            stack.callback(threads.join)
            stack.callback(unconsumed.release, 2 * self.jobs)  # no thread waits for an output to be consumed
            for worker in workers:
                stack.callback(worker.kill)
            stack.callback(threads.terminate)
            for output in threads.imap_unordered(attempt_in_worker, requests):
                yield output
                unconsumed.release()
