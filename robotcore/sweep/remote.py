"""What a worker of a cluster does: the runs of whoever asks, with the files that they bring."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock, Timer

from robotcore.catalogue import app_name
from robotcore.errors import BackendError, RobotcoreError
from robotcore.plan import RunRequest
from robotcore.sweep.command import command_of
from robotcore.sweep.kit import Kit
from robotcore.sweep.worker import Ended, perform, prepare, unfinished

HUNG = 75
"""The exit status of a worker process that ended itself over a run that hung."""

_one_at_a_time = Lock()
"""Modules and their search path belong to the whole process, so that threads of it take turns."""


def perform_there(request: RunRequest, kit: Kit, limit: float) -> Ended:
    """Run as `perform` does, in a worker that may have come since the sweep began.

    A run that takes longer than ``limit`` seconds ends the process: nothing else stops a thread that hangs.
    BackendError where this worker is not fit for the kit.
    """
    if fault := kit.mismatch():
        raise BackendError(refusal(_address(), fault))
    with _one_at_a_time, _ended_after(limit):
        try:
            return _as_asked(perform(_placed(request, kit)), request)
        except OSError as error:  # raised over there, it would look like a connection that is lost
            return unfinished(request, RobotcoreError(f"{type(error).__name__}: {error}"))


def refusal(worker: str, fault: str) -> str:
    """Return the words for a worker that is not fit."""
    return f"the worker {worker} cannot run this: {fault}"


def _address() -> str:
    from distributed import get_worker

    return str(get_worker().address)


def _placed(request: RunRequest, kit: Kit) -> RunRequest:
    """Return the request with the names that the files have here."""
    root = _unpacked(kit)
    return replace(
        request,
        app=kit.app_in(root, request.app),
        judge=kit.app_in(root, request.judge) if request.judge else None,
        robot=kit.description_in(root, request.robot),
        world=kit.description_in(root, request.world) if request.world else None,
    )


def _as_asked(ended: Ended, request: RunRequest) -> Ended:
    """Call the run by the names it was asked for."""
    result = replace(ended.record.result, app=app_name(request.app))
    return Ended(replace(ended.record, result=result, command=command_of(request)), ended.picture)


@contextmanager
def _ended_after(seconds: float) -> Iterator[None]:
    timer = Timer(seconds, os._exit, (HUNG,))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


@cache
def _bench() -> TemporaryDirectory[str]:
    """Return the folder of this process for everyone's files, the process made ready for runs."""
    prepare()
    return TemporaryDirectory(prefix="robotcore-")


def _unpacked(kit: Kit) -> Path:
    """Return where a kit's files are; modules that came from another kit are imported anew."""
    bench = Path(_bench().name)
    root = bench / kit.digest
    if not root.exists():
        kit.unpack(root)
    _forget_others(bench, root)
    return root


def _forget_others(bench: Path, root: Path) -> None:
    def is_other(place: str | None) -> bool:
        return place is not None and Path(place).is_relative_to(bench) and not Path(place).is_relative_to(root)

    sys.path[:] = [place for place in sys.path if not is_other(place)]
    for name in [name for name, module in sys.modules.items() if is_other(getattr(module, "__file__", None))]:
        del sys.modules[name]
