"""The runs of a sweep on the workers of a Dask cluster."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Generator, Iterable
from concurrent.futures import CancelledError, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from robotcore.errors import BackendError, RobotcoreError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.plan import RunRequest
from robotcore.sweep.cluster_worker import JobBundle, format_mismatch, perform_job
from robotcore.sweep.engine import Future, compute_hang_limit, import_extra, iterate_completed
from robotcore.sweep.single_run import RunOutput, make_failed_output
from robotcore.sweep.spec import Sweep

ANSWER_S = 10
"""A scheduler that does not answer within this time counts as absent."""

IDENTITY_S = 5
"""A scheduler says within this time that it is one."""

NO_WORKERS_S = 60.0
"""A cluster that has no worker for so long is given up: those that restart are back by then."""

_AHEAD = 2
"""Runs handed out for each thread of a worker, so that none waits for its next."""


@dataclass(frozen=True)
class ClusterEngine:
    """Runs on the workers of the scheduler at ``address``; what a worker that dies was at is tried on another one."""

    address: str
    wall_timeout_s: float | None = None

    def perform(self, sweep: Sweep, requests: Iterable[RunRequest]) -> Generator[RunOutput, None, None]:
        bundle, limit = JobBundle.of(sweep), compute_hang_limit(sweep.request, self.wall_timeout_s)
        with self._connected() as client:
            self._require_workers(client, bundle)

            def submit(request: RunRequest) -> Future:
                future: Future = client.submit(perform_job, request, bundle, limit, pure=False)
                return future

            workers = _Workers(client, self.address)
            for request, future in iterate_completed(submit, requests, workers.width):
                yield self._ended(request, future, workers)

    def _connected(self) -> Any:  # distributed is imported where it is used, and leaves much untyped
        distributed = import_extra("distributed", "cluster")
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what it has to say, our errors say
        try:
            _check_reachable(distributed.comm.get_address_host_port(self.address))
            _require_scheduler(self.address)
            return distributed.Client(self.address, timeout=ANSWER_S, set_as_default=False)
        except Exception as error:  # something else may answer there, and say anything
            raise BackendError(
                f"no Dask scheduler answers at {self.address!r}. Start one (dask scheduler) and give the address that "
                "it prints, such as tcp://lab:8786",
                kind="no-scheduler",
                address=self.address,
            ) from error

    def _require_workers(self, client: Any, bundle: JobBundle) -> None:
        """Refuse a cluster without workers, or with one that would run something else than this machine would."""
        faults = client.run(JobBundle.mismatch, bundle, on_error="return")
        if not faults:
            raise BackendError(
                f"the cluster at {self.address} has no workers. Start some: dask worker {self.address} --nthreads 1",
                kind="no-workers",
                address=self.address,
            )
        for worker, fault in faults.items():
            if fault:
                raise BackendError(format_mismatch(worker, fault), kind="worker-mismatch", worker=worker)

    def _ended(self, request: RunRequest, future: Future, workers: _Workers) -> RunOutput:
        from distributed import KilledWorker

        try:
            return workers.result_of(future)
        except KilledWorker:
            return make_failed_output(request, BackendError("every worker that tried it died"))
        except BackendError as error:
            raise BackendError(
                f"{error}. What is done is kept; the same command goes on", kind=error.kind, **error.fields
            ) from error
        except (CancelledError, OSError) as error:  # a run's own OSError comes back as its record
            raise _make_gone_error(self.address) from error
        except Exception as error:  # noqa: BLE001  whatever a vendor's library raises costs this run alone
            return make_failed_output(request, RobotcoreError(f"{type(error).__name__}: {error}"))


def _check_reachable(door: tuple[str, int]) -> None:
    """Raise OSError if no program listens; a Dask client would try for long, and print warnings."""
    socket.create_connection(door, timeout=ANSWER_S).close()


def _require_scheduler(address: str) -> None:
    """Raise an error if no scheduler answers; a Dask client would wait for long, and end in a traceback."""
    with ThreadPoolExecutor(1) as thread:  # this thread may have an event loop of its own
        kind = thread.submit(asyncio.run, _read_kind(address)).result()
    if kind != "Scheduler":
        raise OSError(f"{address} is a Dask {kind}")


async def _read_kind(address: str) -> str:
    distributed: Any = import_extra("distributed", "cluster")
    arguments = distributed.Security().get_connection_args("client")
    async with distributed.rpc(address, timeout=IDENTITY_S, connection_args=arguments) as there:
        identity: dict[str, str] = await asyncio.wait_for(there.identity(), IDENTITY_S)
    return identity["type"]


class _Workers:
    """The workers of a cluster, which come and go."""

    def __init__(self, client: Any, address: str) -> None:
        self._client, self._address = client, address
        self._clock, self._last_seen = MonotonicClock(), 0.0

    def width(self) -> int:
        """Return how many runs keep them busy; BackendError if there has been no worker for `NO_WORKERS_S`."""
        now, threads = self._clock.now(), self._threads()
        if threads:
            self._last_seen = now
        elif now - self._last_seen > NO_WORKERS_S:
            raise BackendError(
                f"the cluster at {self._address} has had no workers for {NO_WORKERS_S:g} s. What is done is kept; "
                f"start some (dask worker {self._address} --nthreads 1), and the same command goes on",
                kind="workers-gone",
                address=self._address,
            )
        return _AHEAD * max(threads, 1)

    def result_of(self, future: Any) -> RunOutput:
        """Return what a run came to; where the worker that has its result dies, it is run again, and waited for."""
        while (ended := _await_result(future)) is None:
            self.width()
        return ended

    def _threads(self) -> int:
        try:
            threads: dict[str, int] = self._client.nthreads()
        except Exception as error:  # of Dask, of its network library, of the system: nobody answers
            raise _make_gone_error(self._address) from error
        return sum(threads.values())


def _make_gone_error(address: str) -> BackendError:
    return BackendError(
        f"the scheduler at {address} is gone. What is done is kept; the same command goes on",
        kind="scheduler-gone",
        address=address,
    )


def _await_result(future: Any) -> RunOutput | None:
    """Return a run's output; None if it is not there within `ANSWER_S` seconds."""
    from distributed import TimeoutError as AwaitedTooLongError

    try:
        ended: RunOutput = future.result(timeout=ANSWER_S)
    except AwaitedTooLongError:
        if future.status == "error":  # the run's own
            raise
        return None
    return ended
