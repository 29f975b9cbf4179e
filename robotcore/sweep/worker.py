"""What a worker process does: one run after another, each told as a record.

Nothing heavy is imported with this module, so that `prepare` comes before NumPy starts its threads.
"""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from dataclasses import replace
from multiprocessing import parent_process
from threading import Thread
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from robotcore.errors import RobotcoreError
    from robotcore.outcome import RunResult
    from robotcore.plan import RunRequest
    from robotcore.sweep.record import Record

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


class Ended(NamedTuple):
    """A run that has ended; ``picture`` is the PNG of a failing one."""

    record: Record
    picture: bytes | None = None


def prepare() -> None:
    """Make a process ready for runs: one thread each, everything imported."""
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    import cv2

    import robotcore.session
    import robotcore.view.picture  # noqa: F401

    cv2.setNumThreads(1)


def prepare_child() -> None:
    """Make a child process ready: Ctrl-C in the terminal is its parent's business, and it does not outlive it.

    What an app prints goes to standard error: the standard output is the sweep's own.
    """
    os.dup2(2, 1)
    sys.stdout = sys.stderr  # line by line: what waits in a buffer is lost with the worker
    os.setpgid(0, 0)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    Thread(target=_end_with_parent, daemon=True).start()
    prepare()


def perform(request: RunRequest) -> Ended:
    """Run, and tell how it ended, whatever that was."""
    from robotcore.errors import RobotcoreError
    from robotcore.session import run
    from robotcore.sweep.command import command_of
    from robotcore.sweep.path import PathRecorder
    from robotcore.sweep.record import Record
    from robotcore.view.picture import PictureRecorder

    path, picture = PathRecorder(), PictureRecorder()
    try:
        result = run(request, [path, picture])
    except RobotcoreError as error:
        result = _unstarted(request, error)
    # An app's own exception may not fit through a pipe; its words are in the reason.
    record = Record(replace(result, error=None), path.path, command_of(request))
    return Ended(record, picture.png() if record.is_failure else None)


def perform_in_child(request: RunRequest) -> Ended:
    """Run as `perform` does; a process that was told to end in the middle of it does so."""
    from robotcore.outcome import Outcome

    ended = perform(request)
    if ended.record.result.outcome is Outcome.INTERRUPTED:
        os._exit(ended.record.result.exit_status)
    return ended


def unfinished(request: RunRequest, error: RobotcoreError) -> Ended:
    """Tell of a run whose process did not live to tell of it."""
    from robotcore.sweep.command import command_of
    from robotcore.sweep.record import Record

    return Ended(Record(_unstarted(request, error), None, command_of(request)))


def _unstarted(request: RunRequest, error: RobotcoreError) -> RunResult:
    from robotcore.catalogue import app_name
    from robotcore.description import load_robot, load_world
    from robotcore.outcome import Outcome, RunResult

    return RunResult(
        app=app_name(request.app),
        backend=request.backend,
        robot=load_robot(request.robot).name,
        world=load_world(request.world).name if request.world else None,
        seed=request.seed,
        outcome=Outcome.ERROR,
        exit_status=error.exit_status,
        reason=str(error),
        conditions=_drawn(request),
    )


def _drawn(request: RunRequest) -> dict[str, float | str]:
    """Return the conditions that the run was to be under; none where it cannot even be planned."""
    from robotcore.plan import Plan

    with suppress(Exception):  # the user's own app is made for it, and may raise anything
        return dict(Plan.of(request).drawn)
    return {}


def _end_with_parent() -> None:
    if parent := parent_process():
        parent.join()
        os._exit(1)
