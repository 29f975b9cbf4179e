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

_AHEAD = 2
"""Runs handed out for each process, so that none waits for its next."""


def run_sweep(
    sweep: Sweep,
    engine: Engine | None = None,
    directory: Path | None = None,
    *,
    fresh: bool = False,
) -> Results:
    """Run what is not yet done of a sweep, on all cores where no engine is given; return its results.

    Raises UsageError and BackendMissingError before anything is run.
    """
    preflight(sweep)
    with Results(sweep, directory, fresh=fresh) as results:
        execute(results, engine or LocalEngine(count_cores()))
    return results


def execute(results: Results, engine: Engine, watch: RecordCallback = lambda _: None) -> None:
    """Run what is missing, and write the tables of what is there, however it ends."""
    try:
        if missing := results.missing():
            with closing(engine.perform(results.sweep, missing)) as ended:
                for each in ended:
                    watch(results.add(each))
    finally:
        results.write_tables()


def count_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True)
class LocalEngine:
    """Runs in ``jobs`` processes of their own; a run that takes longer than ``wall_timeout_s`` is given up."""

    jobs: int
    wall_timeout_s: float | None = None

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[RunOutput, None, None]:
        limit = compute_hang_limit(sweep.request, self.wall_timeout_s)
        with _start_workers(self.jobs) as (threads, idle):

            def attempted(request: RunRequest) -> RunOutput:
                worker = idle.get()
                try:
                    return attempt(worker, request, limit)
                finally:
                    idle.put(worker)

            def submit(request: RunRequest) -> Future:
                return threads.submit(attempted, request)

            for _, future in iterate_completed(submit, requests, lambda: _AHEAD * self.jobs):
                ended: RunOutput = future.result()
                yield ended


@contextmanager
def _start_workers(size: int) -> Iterator[tuple[ThreadPoolExecutor, SimpleQueue[WorkerProcess]]]:
    """Give as many threads as child processes for them to take; on leaving, all are ended, whatever they are at."""
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
