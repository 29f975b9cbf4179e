"""The part of a sweep that a worker of a Dask cluster executes: unpack the user's files, and execute a run."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock

from robotcore.description import is_own
from robotcore.errors import BackendError, RobotcoreError
from robotcore.runtime.apps import app_name, app_path, is_app_file
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.versions import libraries
from robotcore.sweep.fingerprint import compute_code_digests, read_own_files
from robotcore.sweep.single_run import RunOutput, attempt, build_failed_output
from robotcore.sweep.spec import Sweep, format_command
from robotcore.sweep.worker import WorkerProcess

_worker_lock = Lock()
"""A thread holds this lock during a run. All threads of a Dask worker share one worker process."""

_workers: dict[Path, WorkerProcess] = {}
"""The worker process by the folder of its unpacked bundle. The dict has at most one entry."""


def perform_job(request: RunRequest, bundle: JobBundle, limit_s: float) -> RunOutput:
    """Execute a run with `attempt`, and return its output, with the file names of the request.

    request: the run, with the file names of the machine that started the sweep.
    bundle: the files of the sweep.
    limit_s: the time limit of the run, in seconds of wall time.

    Raises BackendError if this worker's software differs from the bundle's. The sweep checks all workers when it
    starts, but a worker may join the cluster later.
    """
    if mismatch := bundle.find_mismatch():
        from distributed import get_worker

        address = str(get_worker().address)
        raise BackendError(format_mismatch(address, mismatch), kind="worker-mismatch", worker=address)
    with _worker_lock:
        try:
            root = Path(_make_bundles_folder().name) / bundle.digest
            if not root.exists():
                bundle.unpack(root)
        except OSError as error:  # the engine would take an OSError for a lost connection
            return build_failed_output(request, RobotcoreError(f"{type(error).__name__}: {error}"))
        local = bundle.localize(request, root)
        return _restore_names(attempt(_get_worker(root), local, limit_s), request, local)


def format_mismatch(worker: str, mismatch: str) -> str:
    """Return the error message for a worker whose software differs from the sweep's.

    worker: the address of the worker.
    mismatch: the difference, as `JobBundle.find_mismatch` returns it.
    """
    return f"the worker {worker} cannot run this sweep: {mismatch}"


def _restore_names(output: RunOutput, request: RunRequest, local: RunRequest) -> RunOutput:
    """Replace each unpacked file name in an output by the user's name, also in the reason of the result.

    request: the run with the user's file names.
    local: the same run with the unpacked file names.
    """
    reason = output.record.result.reason
    for original, unpacked in zip(_list_file_names(request), _list_file_names(local), strict=True):
        reason = reason.replace(unpacked, original)
    judge = app_name(request.judge) if request.judge else None
    result = replace(output.record.result, app=app_name(request.app_reference), judge=judge, reason=reason)
    return RunOutput(replace(output.record, result=result, command=format_command(request)), output.picture)


def _list_file_names(request: RunRequest) -> list[str]:
    """Return the names in a request that may be file names, without the class in ``app.py:Class``."""
    apps = [str(app_path(name)) for name in (request.app_reference, request.judge) if name]
    return [*apps, request.robot, *filter(None, [request.world])]


@cache
def _make_bundles_folder() -> TemporaryDirectory[str]:
    """Return the folder in which this process unpacks bundles. The first call creates it."""
    return TemporaryDirectory(prefix="robotcore-")


def _get_worker(root: Path) -> WorkerProcess:
    """Return the worker process of a bundle. A process of another bundle has imported other files, so it is closed."""
    for other in [each for each in _workers if each != root]:
        _workers.pop(other).close()
    return _workers.setdefault(root, WorkerProcess())


@dataclass(frozen=True)
class JobBundle:
    """The user's files that the runs of a sweep need, and the versions of the software that the runs use."""

    sweep: Sweep
    """The sweep, without its seeds."""

    software: Mapping[str, str]
    """The versions of Python and the libraries, and the digests of the installed code, by name."""

    home: Path
    """The working directory of the sweep. Relative file names of the user start there."""

    files: Mapping[Path, bytes]
    """The contents of the files, by their absolute paths."""

    @classmethod
    def from_sweep(cls, sweep: Sweep) -> JobBundle:
        """Read the files of a sweep, and return its bundle. `Sweep.check` must have found no error."""
        return cls(replace(sweep, seeds=()), _collect_software(sweep), Path.cwd(), read_own_files(sweep))

    def find_mismatch(self) -> str | None:
        """Return how this process's software differs from the bundle's, and a remedy. Return None if both are equal."""
        try:
            found = _collect_software(self.sweep)
        except RobotcoreError as error:
            return str(error)
        differing = [
            f"{name} is {found.get(name, 'not installed')} on the worker and {wanted} on this machine"
            for name, wanted in self.software.items()
            if found.get(name) != wanted
        ]
        remedy = "Install the same software on the worker, and restart it"
        return f"{'; '.join(differing)}. {remedy}" if differing else None

    @property
    def digest(self) -> str:
        """The SHA-256 digest of the files and their paths."""
        total = hashlib.sha256()
        for file, content in sorted(self.files.items()):
            total.update(b"%b %b" % (os.fsencode(file), hashlib.sha256(content).digest()))
        return total.hexdigest()

    def unpack(self, root: Path) -> None:
        """Create the folder ``root``, and write all files into it. After an error, the folder does not exist.

        Files of one original folder are in one folder below ``root``, so that modules can import each other.
        """
        with TemporaryDirectory(dir=root.parent) as folder:
            part = Path(folder, root.name)
            part.mkdir()
            for file, content in self.files.items():
                path = part / _make_unpacked_path(file)
                path.parent.mkdir(exist_ok=True)
                path.write_bytes(content)
            part.rename(root)

    def localize(self, request: RunRequest, root: Path) -> RunRequest:
        """Return a request with the names of the unpacked files below ``root``. Shipped names stay unchanged."""

        def locate(name: str) -> str:
            return str(root / _make_unpacked_path(self.home / name))

        def locate_app(name: str) -> str:
            return locate(name) if is_app_file(name) else name

        def locate_description(name: str) -> str:
            return locate(name) if is_own(name) else name

        return replace(
            request,
            app=locate_app(request.app_reference),
            judge=locate_app(request.judge) if request.judge else None,
            robot=locate_description(request.robot),
            world=locate_description(request.world) if request.world else None,
        )


def _collect_software(sweep: Sweep) -> dict[str, str]:
    digests = compute_code_digests(sweep.apps, sweep.backends, sweep.request.faults)
    return {**libraries(sweep.backends), **{f"the code of {name}": digest[:16] for name, digest in digests.items()}}


def _make_unpacked_path(file: Path) -> Path:
    """Return the path of an unpacked file in its bundle: the digest of the original folder, and the file's name."""
    folder = hashlib.sha256(os.fsencode(file.parent)).hexdigest()[:16]
    return Path(folder, file.name)
