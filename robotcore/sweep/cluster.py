"""The engine that executes runs on a Dask cluster."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Generator, Iterable
from concurrent.futures import CancelledError, ThreadPoolExecutor
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from queue import Empty, SimpleQueue
from typing import Any

from robotcore.errors import BackendError, RobotcoreError
from robotcore.extras import require_extra
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.plan import RunRequest
from robotcore.sweep.cluster_worker import JobBundle, format_mismatch, perform_job
from robotcore.sweep.engine import compute_hang_limit
from robotcore.sweep.single_run import RunOutput, build_failed_output
from robotcore.sweep.spec import Sweep

ANSWER_S = 10
"""The time limit for connecting to a scheduler and for one wait for a result, in seconds."""

IDENTITY_S = 5
"""The time limit for a scheduler's answer to a request for its identity, in seconds."""

NO_WORKERS_S = 60.0
"""The seconds without any worker after which the sweep ends. A worker needs less time to restart."""

POLL_S = 1.0
"""The interval in seconds at which the engine counts the workers."""

_RUNS_PER_THREAD = 2
"""The number of runs to submit for each thread of a worker, so that no thread waits for its next run."""

_RESUME_HINT = "The finished runs are saved. The same command resumes the sweep"


@dataclass(frozen=True)
class ClusterEngine:
    """Executes runs on the workers of a Dask scheduler. If a worker dies, another one repeats its run.

    >>> ClusterEngine("tcp://lab:8786", wall_timeout_s=600.0)
    ClusterEngine(address='tcp://lab:8786', wall_timeout_s=600.0)
    """

    address: str
    """The address of the scheduler, such as ``tcp://lab:8786``."""

    wall_timeout_s: float | None = None
    """The seconds of wall time after which a run counts as hung. None means ten times its time limit, plus a minute."""

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[RunOutput, None, None]:
        bundle, limit = JobBundle.from_sweep(sweep), compute_hang_limit(sweep.request, self.wall_timeout_s)
        ended: SimpleQueue[tuple[RunRequest, Any]] = SimpleQueue()
        waiting, unfinished = iter(requests), 0

        def submit(request: RunRequest) -> None:
            future = client.submit(perform_job, request, bundle, limit, pure=False)
            future.add_done_callback(lambda done: ended.put((request, done)))

        with self._connect() as client:
            self._require_workers(client, bundle)
            workers = _Workers(client, self.address)
            while True:
                for request in islice(waiting, max(workers.count_allowed_runs() - unfinished, 0)):
                    submit(request)
                    unfinished += 1
                if not unfinished:
                    return
                try:
                    request, future = ended.get(timeout=POLL_S)
                except Empty:
                    continue
                unfinished -= 1
                yield workers.await_output(request, future)

    def _connect(self) -> Any:  # distributed leaves much untyped
        require_extra("cluster", "--cluster")
        distributed = import_module("distributed")
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # the errors below replace its messages
        try:
            # A Dask client would retry for a long time, or leave a thread, if no scheduler is at the address.
            socket.create_connection(distributed.comm.get_address_host_port(self.address), timeout=ANSWER_S).close()
            with ThreadPoolExecutor(1) as thread:  # the caller's thread may already run an event loop
                thread.submit(asyncio.run, _require_scheduler(distributed, self.address)).result()
            return distributed.Client(self.address, timeout=ANSWER_S, set_as_default=False)
        except Exception as error:  # another program at the address may send anything
            raise BackendError(
                f"no Dask scheduler answers at {self.address!r}. Start one (dask scheduler), and use the address that "
                "it prints, such as tcp://lab:8786",
                kind="no-scheduler",
                address=self.address,
            ) from error

    def _require_workers(self, client: Any, bundle: JobBundle) -> None:
        """Raise BackendError if the cluster has no worker, or a worker whose software differs from this machine's."""
        mismatches = client.run(JobBundle.find_mismatch, bundle, on_error="return")
        if not mismatches:
            raise BackendError(
                f"the cluster at {self.address} has no workers. Start some: dask worker {self.address} --nthreads 1",
                kind="no-workers",
                address=self.address,
            )
        for worker, mismatch in mismatches.items():
            if mismatch:
                raise BackendError(format_mismatch(worker, mismatch), kind="worker-mismatch", worker=worker)


async def _require_scheduler(distributed: Any, address: str) -> None:
    arguments = distributed.Security().get_connection_args("client")
    async with distributed.rpc(address, timeout=IDENTITY_S, connection_args=arguments) as remote:
        identity = await asyncio.wait_for(remote.identity(), IDENTITY_S)
    if identity["type"] != "Scheduler":
        raise OSError(f"{address} is a Dask {identity['type']}, not a scheduler")


class _Workers:
    def __init__(self, client: Any, address: str) -> None:
        self._client, self._address = client, address
        self._clock, self._last_seen = MonotonicClock(), 0.0

    def count_allowed_runs(self) -> int:
        """Return how many runs may be submitted and unfinished at a time.

        Raises BackendError after `NO_WORKERS_S` seconds without workers, or if the scheduler is gone.
        """
        try:
            threads = int(sum(self._client.nthreads().values()))
        except Exception as error:  # Dask, its network library and the system raise many types
            raise self._make_gone_error() from error
        now = self._clock.now()
        if threads:
            self._last_seen = now
        elif now - self._last_seen > NO_WORKERS_S:
            raise BackendError(
                f"the cluster at {self._address} has had no workers for {NO_WORKERS_S:g} s. Start some: "
                f"dask worker {self._address} --nthreads 1. {_RESUME_HINT}",
                kind="workers-gone",
                address=self._address,
            )
        return _RUNS_PER_THREAD * max(threads, 1)

    def await_output(self, request: RunRequest, future: Any) -> RunOutput:
        """Return the output of a run that has ended. Dask repeats the run if the output is lost with its worker."""
        import distributed

        try:
            while True:
                try:
                    output: RunOutput = future.result(timeout=ANSWER_S)
                except distributed.TimeoutError:  # noqa: PERF203  each wait takes seconds
                    if future.status == "error":  # the run itself raised TimeoutError
                        raise
                    self.count_allowed_runs()
                else:
                    return output
        except distributed.KilledWorker:
            return build_failed_output(request, BackendError("each worker that executed this run died"))
        except BackendError as error:
            if error.kind != "worker-mismatch":  # other BackendErrors contain the hint already
                raise
            raise BackendError(f"{error}. {_RESUME_HINT}", kind=error.kind, **error.fields) from error
        except (CancelledError, OSError) as error:  # Dask lost the scheduler; an OSError of the run is in its record
            raise self._make_gone_error() from error
        except Exception as error:  # noqa: BLE001  if a vendor's library raises, only this run fails
            return build_failed_output(request, RobotcoreError(f"{type(error).__name__}: {error}"))

    def _make_gone_error(self) -> BackendError:
        return BackendError(
            f"the scheduler at {self._address} is gone. Start it again. {_RESUME_HINT}",
            kind="scheduler-gone",
            address=self._address,
        )
