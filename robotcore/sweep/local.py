"""Run a sweep, by default on the cores of this machine."""

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
"""The number of runs to submit for each worker process. A worker then always has its next run at hand."""


def run_sweep(
    sweep: Sweep,
    engine: Engine | None = None,
    directory: Path | None = None,
    *,
    fresh: bool = False,
) -> Results:
    """Execute the missing runs of a sweep, and return its results. `Results` has an example.

    sweep: the sweep.
    engine: the engine; None for a `LocalEngine` on all cores.
    directory: the folder of the results; None for ``sweeps/<app>-<digest>``.
    fresh: whether to delete the results that exist.

    Raises UsageError, BackendError and BehaviourError before the first run, as `preflight` does.
    """
    preflight(sweep)
    with Results(sweep, directory, fresh=fresh) as results:
        execute(results, engine or LocalEngine(count_cores()))
    return results


def execute(results: Results, engine: Engine, watch: RecordCallback = lambda _: None) -> None:
    """Execute the missing runs, and call ``watch`` with each record. Then write the tables, even after an error."""
    try:
        if missing := results.missing():
            with closing(engine.perform(results.sweep, missing)) as outputs:
                for output in outputs:
                    watch(results.add(output))
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
    """The seconds of wall time after which a run counts as hung; None for ten times its time limit and a minute."""

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
    """Yield threads, and a queue with an idle worker for each thread. On exit, kill all workers, even during a run."""
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
