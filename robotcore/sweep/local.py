"""Run a sweep, and the engine that executes runs on the cores of this machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

from robotcore.runtime.plan import RunRequest
from robotcore.sweep.engine import Engine, Future, compute_hang_limit, iterate_completed
from robotcore.sweep.preflight import preflight
from robotcore.sweep.record import Record
from robotcore.sweep.results import Results
from robotcore.sweep.single_run import RunOutput, attempt
from robotcore.sweep.spec import Sweep
from robotcore.sweep.worker import WorkerProcess

RecordCallback = Callable[[Record], None]

_RUNS_PER_WORKER = 2
"""The number of runs to submit for each worker process, so that no process waits for its next run."""


def run_sweep(
    sweep: Sweep,
    engine: Engine | None = None,
    directory: Path | None = None,
    *,
    fresh: bool = False,
) -> Results:
    """Execute the runs of a sweep that its folder does not have yet, and return the results. `Results` has an example.

    sweep: the sweep.
    engine: the engine. None means a `LocalEngine` on all cores.
    directory: the folder of the results. None means ``sweeps/<app>-<digest>``.
    fresh: whether to delete all results in the folder first.

    Raises the errors of `preflight` before the first run.
    """
    preflight(sweep)
    with Results(sweep, directory, fresh=fresh) as results:
        execute(results, engine or LocalEngine(count_cores()))
    return results


def execute(results: Results, engine: Engine, on_record: RecordCallback = lambda _: None) -> None:
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


@dataclass(frozen=True)
class LocalEngine:
    """Executes runs in worker processes on this machine."""

    jobs: int
    """The number of worker processes."""

    wall_timeout_s: float | None = None
    """The seconds of wall time after which a run counts as hung. None means ten times its time limit, plus a minute."""

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[RunOutput, None, None]:
        limit = compute_hang_limit(sweep.request, self.wall_timeout_s)
        with _start_workers(self.jobs) as (threads, idle):

            def attempt_in_worker(request: RunRequest) -> RunOutput:
                worker = idle.get()
                try:
                    return attempt(worker, request, limit)
                finally:
                    idle.put(worker)

            def submit(request: RunRequest) -> Future:
                return threads.submit(attempt_in_worker, request)

            for _, future in iterate_completed(submit, requests, lambda: _RUNS_PER_WORKER * self.jobs):
                output: RunOutput = future.result()
                yield output


@contextmanager
def _start_workers(size: int) -> Iterator[tuple[ThreadPoolExecutor, SimpleQueue[WorkerProcess]]]:
    """Yield a pool of threads, and a queue with one idle worker process for each thread.

    On exit, kill all worker processes, even during a run.
    """
    idle: SimpleQueue[WorkerProcess] = SimpleQueue()
    with ExitStack() as stack:
        threads = ThreadPoolExecutor(size)
        workers = [WorkerProcess() for _ in range(size)]
        for worker in workers:
            stack.callback(worker.close)
            idle.put(worker)
        stack.callback(threads.shutdown)
        for worker in workers:
            stack.callback(worker.kill)
        stack.callback(threads.shutdown, wait=False, cancel_futures=True)
        yield threads, idle
