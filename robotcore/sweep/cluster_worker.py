"""Run jobs on a worker of a Dask cluster, with the user's files unpacked there."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock

from robotcore.description import is_own
from robotcore.errors import BackendError, RobotcoreError
from robotcore.runtime.apps import app_name, app_path, is_app_file
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.versions import PYTHON, libraries
from robotcore.sweep.fingerprint import code_digest, read_own_files
from robotcore.sweep.single_run import RunOutput, attempt, make_failed_output
from robotcore.sweep.spec import Sweep, format_command
from robotcore.sweep.worker import WorkerProcess

_worker_lock = Lock()
"""The threads of a worker take turns with its one child process."""

_workers: dict[Path, WorkerProcess] = {}
"""The child process, by the folder of the bundle that it runs."""


def perform_job(request: RunRequest, bundle: JobBundle, limit_s: float) -> RunOutput:
    """Run as `attempt` does, in a worker that may have come since the sweep began.

    BackendError if this worker's software differs from the bundle's.
    """
    if fault := bundle.mismatch():
        address = _read_address()
        raise BackendError(format_mismatch(address, fault), kind="worker-mismatch", worker=address)
    with _worker_lock:
        try:
            root = _unpack_bundle(bundle)
        except OSError as error:  # raised over there, it would look like a connection that is lost
            return make_failed_output(request, RobotcoreError(f"{type(error).__name__}: {error}"))
        local = _localize_request(request, bundle, root)
        return _restore_names(attempt(_get_worker(root), local, limit_s), request, local)


def format_mismatch(worker: str, fault: str) -> str:
    """Return the message for a worker whose software differs."""
    return f"the worker {worker} cannot run this: {fault}"


def _read_address() -> str:
    from distributed import get_worker

    return str(get_worker().address)


def _localize_request(request: RunRequest, bundle: JobBundle, root: Path) -> RunRequest:
    """Return the request with the names that the files have here."""
    return replace(
        request,
        app=bundle.app_in(root, request.app),
        judge=bundle.app_in(root, request.judge) if request.judge else None,
        robot=bundle.description_in(root, request.robot),
        world=bundle.description_in(root, request.world) if request.world else None,
    )


def _restore_names(ended: RunOutput, request: RunRequest, local: RunRequest) -> RunOutput:
    """Call the run, and the files that its reason speaks of, by the names it was asked for."""
    reason = ended.record.result.reason
    for asked, here in zip(_list_file_names(request), _list_file_names(local), strict=True):
        reason = reason.replace(here, asked)
    judge = app_name(request.judge) if request.judge else None
    result = replace(ended.record.result, app=app_name(request.app), judge=judge, reason=reason)
    return RunOutput(replace(ended.record, result=result, command=format_command(request)), ended.picture)


def _list_file_names(request: RunRequest) -> list[str]:
    """Return what a request names that may be files, an app's without the class in it."""
    apps = [str(app_path(name)) for name in (request.app, request.judge) if name]
    return [*apps, request.robot, *filter(None, [request.world])]


@cache
def _make_bundles_folder() -> TemporaryDirectory[str]:
    """Return the folder of this process for everyone's files."""
    return TemporaryDirectory(prefix="robotcore-")


def _unpack_bundle(bundle: JobBundle) -> Path:
    """Return where a bundle's files are."""
    root = Path(_make_bundles_folder().name) / bundle.digest
    if not root.exists():
        bundle.unpack(root)
    return root


def _get_worker(root: Path) -> WorkerProcess:
    """Return a process that has imported nothing of any other bundle; the one of another ends."""
    for other in [each for each in _workers if each != root]:
        _workers.pop(other).close()
    return _workers.setdefault(root, WorkerProcess())


@dataclass(frozen=True)
class JobBundle:
    """The own files of a sweep by their absolute paths, ``home`` being where relative names begin."""

    apps: tuple[str, ...]
    backends: tuple[str, ...]
    faults: tuple[str, ...]
    versions: Mapping[str, str]
    code: str
    home: Path
    files: Mapping[Path, bytes]

    @classmethod
    def of(cls, sweep: Sweep) -> JobBundle:
        """Return the bundle of a sweep that was checked."""
        named = sweep.apps, sweep.backends, sweep.request.faults
        return cls(*named, _read_versions(sweep.backends), code_digest(*named), Path.cwd(), read_own_files(sweep))

    def mismatch(self) -> str | None:
        """Return why this process cannot run the bundle; None if it can."""
        try:
            found, code = _read_versions(self.backends), code_digest(self.apps, self.backends, self.faults)
        except RobotcoreError as error:
            return str(error)
        for name, wanted in self.versions.items():
            if (has := found.get(name, "none")) != wanted:
                return f"{name}: it has {has}, here is {wanted}. {_format_remedy(name, wanted)}, and start it again"
        if code != self.code:
            return "its robotcore, drivers, apps or faults are not ours. Install the same, and start it again"
        return None

    @property
    def digest(self) -> str:
        """A digest of the files and their places."""
        total = hashlib.sha256()
        for file, content in sorted(self.files.items()):
            total.update(b"%b %b" % (os.fsencode(file), hashlib.sha256(content).digest()))
        return total.hexdigest()

    def unpack(self, root: Path) -> None:
        """Make ``root`` with the files below it, all or none; those of one folder stay beside each other."""
        with TemporaryDirectory(dir=root.parent) as folder:
            part = Path(folder, root.name)
            part.mkdir()
            for file, content in self.files.items():
                path = part / _relative_path(file)
                path.parent.mkdir(exist_ok=True)
                path.write_bytes(content)
            part.rename(root)

    def app_in(self, root: Path, name: str) -> str:
        """Return an app's name where the files are unpacked below ``root``."""
        return str(root / _relative_path(self.home / name)) if is_app_file(name) else name

    def description_in(self, root: Path, name: str) -> str:
        """Return a robot's or a world's name where the files are unpacked below ``root``."""
        return str(root / _relative_path(self.home / name)) if is_own(name) else name


def _read_versions(backends: tuple[str, ...]) -> dict[str, str]:
    return {"robotcore": version("robotcore"), **libraries(backends)}


def _format_remedy(name: str, wanted: str) -> str:
    return f"Take the same {name} there" if name == PYTHON else f"pip install {name}=={wanted} there"


def _relative_path(file: Path) -> Path:
    """Return a relative place for an absolute one; no ``..`` in it leads anywhere else."""
    folder = hashlib.sha256(os.fsencode(file.parent)).hexdigest()[:16]
    return Path(folder, file.name)
