"""What a worker of a cluster does: the runs of whoever asks, with the files that they bring."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock

from robotcore.errors import BackendError, RobotcoreError
from robotcore.runtime.apps import app_name, app_path
from robotcore.runtime.plan import RunRequest
from robotcore.sweep.child import Child
from robotcore.sweep.command import command_of
from robotcore.sweep.kit import Kit
from robotcore.sweep.worker import Ended, attempt, unfinished

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
