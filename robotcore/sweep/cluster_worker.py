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
from robotcore.sweep.fingerprint import code_digest, own_files
from robotcore.sweep.single_run import Ended, attempt, unfinished
from robotcore.sweep.spec import Sweep, command_of
from robotcore.sweep.worker import Child

_one_at_a_time = Lock()
"""The threads of a worker take turns with its one child process."""

_children: dict[Path, Child] = {}
"""The child process, by the folder of the kit that it runs."""


def perform_there(request: RunRequest, kit: Kit, limit_s: float) -> Ended:
    """Run as `attempt` does, in a worker that may have come since the sweep began.

    BackendError where this worker is not fit for the kit.
    """
    if fault := kit.mismatch():
        raise BackendError(refusal(_address(), fault))
    with _one_at_a_time:
        try:
            root = _unpacked(kit)
        except OSError as error:  # raised over there, it would look like a connection that is lost
            return unfinished(request, RobotcoreError(f"{type(error).__name__}: {error}"))
        placed = _placed(request, kit, root)
        return _as_asked(attempt(_child_of(root), placed, limit_s), request, placed)


def refusal(worker: str, fault: str) -> str:
    """Return the words for a worker that is not fit."""
    return f"the worker {worker} cannot run this: {fault}"


def _address() -> str:
    from distributed import get_worker

    return str(get_worker().address)


def _placed(request: RunRequest, kit: Kit, root: Path) -> RunRequest:
    """Return the request with the names that the files have here."""
    return replace(
        request,
        app=kit.app_in(root, request.app),
        judge=kit.app_in(root, request.judge) if request.judge else None,
        robot=kit.description_in(root, request.robot),
        world=kit.description_in(root, request.world) if request.world else None,
    )


def _as_asked(ended: Ended, request: RunRequest, placed: RunRequest) -> Ended:
    """Call the run, and the files that its reason speaks of, by the names it was asked for."""
    reason = ended.record.result.reason
    for asked, here in zip(_named(request), _named(placed), strict=True):
        reason = reason.replace(here, asked)
    judge = app_name(request.judge) if request.judge else None
    result = replace(ended.record.result, app=app_name(request.app), judge=judge, reason=reason)
    return Ended(replace(ended.record, result=result, command=command_of(request)), ended.picture)


def _named(request: RunRequest) -> list[str]:
    """Return what a request names that may be files, an app's without the class in it."""
    apps = [str(app_path(name)) for name in (request.app, request.judge) if name]
    return [*apps, request.robot, *filter(None, [request.world])]


@cache
def _bench() -> TemporaryDirectory[str]:
    """Return the folder of this process for everyone's files."""
    return TemporaryDirectory(prefix="robotcore-")


def _unpacked(kit: Kit) -> Path:
    """Return where a kit's files are."""
    root = Path(_bench().name) / kit.digest
    if not root.exists():
        kit.unpack(root)
    return root


def _child_of(root: Path) -> Child:
    """Return a process that has imported nothing of any other kit; the one of another ends."""
    for other in [each for each in _children if each != root]:
        _children.pop(other).close()
    return _children.setdefault(root, Child())


@dataclass(frozen=True)
class Kit:
    """The own files of a sweep by their absolute paths, ``home`` being where relative names begin."""

    apps: tuple[str, ...]
    backends: tuple[str, ...]
    faults: tuple[str, ...]
    versions: Mapping[str, str]
    code: str
    home: Path
    files: Mapping[Path, bytes]

    @classmethod
    def of(cls, sweep: Sweep) -> Kit:
        """Return the kit of a sweep that was checked."""
        named = sweep.apps, sweep.backends, sweep.request.faults
        return cls(*named, _versions(sweep.backends), code_digest(*named), Path.cwd(), own_files(sweep))

    def mismatch(self) -> str | None:
        """Return why this process cannot run what the kit is for; None where it can."""
        try:
            found, code = _versions(self.backends), code_digest(self.apps, self.backends, self.faults)
        except RobotcoreError as error:
            return str(error)
        for name, wanted in self.versions.items():
            if (has := found.get(name, "none")) != wanted:
                return f"{name}: it has {has}, here is {wanted}. {_remedy(name, wanted)}, and start it again"
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
            unfinished = Path(folder, root.name)
            unfinished.mkdir()
            for file, content in self.files.items():
                place = unfinished / _place(file)
                place.parent.mkdir(exist_ok=True)
                place.write_bytes(content)
            unfinished.rename(root)

    def app_in(self, root: Path, name: str) -> str:
        """Return an app's name where the files are unpacked below ``root``."""
        return str(root / _place(self.home / name)) if is_app_file(name) else name

    def description_in(self, root: Path, name: str) -> str:
        """Return a robot's or a world's name where the files are unpacked below ``root``."""
        return str(root / _place(self.home / name)) if is_own(name) else name


def _versions(backends: tuple[str, ...]) -> dict[str, str]:
    return {"robotcore": version("robotcore"), **libraries(backends)}


def _remedy(name: str, wanted: str) -> str:
    return f"Take the same {name} there" if name == PYTHON else f"pip install {name}=={wanted} there"


def _place(file: Path) -> Path:
    """Return a relative place for an absolute one; no ``..`` in it leads anywhere else."""
    folder = hashlib.sha256(os.fsencode(file.parent)).hexdigest()[:16]
    return Path(folder, file.name)
