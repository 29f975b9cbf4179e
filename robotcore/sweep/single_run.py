"""Execute one run of a sweep, in this process or in a worker process."""

from __future__ import annotations

import os
from base64 import b64decode, b64encode
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from robotcore.description import load_robot, load_world
from robotcore.errors import BackendError, RobotcoreError
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.runtime.apps import app_name
from robotcore.runtime.plan import RunRequest, draw_conditions
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.session import run
from robotcore.sweep.record import PathRecorder, Record, shorten
from robotcore.sweep.spec import format_command
from robotcore.sweep.worker import NoWorkerError, WorkerEndedError, WorkerProcess
from robotcore.view.picture import PictureRecorder

TIMEOUT_SCALE = 10.0
"""The factor by which a sweep multiplies the time limits of apps and simulators.

All cores are busy in a sweep, and a slow machine must not change results. Longer limits are safe, because no real
robot moves.
"""


class RunOutput(NamedTuple):
    """The output of a run that has ended: its record and its picture."""

    record: Record
    """The record of the run. Its field ``picture`` is still None."""

    picture: bytes | None = None
    """The picture of a failing run as the bytes of a PNG file; None for a passing run."""


def perform(request: RunRequest) -> RunOutput:
    """Execute a run in this process, and return its output. After a RobotcoreError, the outcome is ``error``."""
    path, picture = PathRecorder(), PictureRecorder()
    try:
        result = run(request, [path, picture], timeout_scale=TIMEOUT_SCALE)
    except RobotcoreError as error:
        result = _make_error_result(request, error)
    # The error may hold objects of the app that do not pickle. Its text is in the reason.
    record = Record(shorten(replace(result, error=None)), path.path, format_command(request))
    return RunOutput(record, picture.png() if record.is_failure else None)


def attempt(worker: WorkerProcess, request: RunRequest, limit_s: float) -> RunOutput:
    """Execute a run in a worker process, and return its output.

    worker: the process.
    request: the run.
    limit_s: the time limit of the run, in seconds of wall time.

    The run has the outcome ``error`` if the process dies or hangs, or if its reply is not the output of this run. An
    error in the reply becomes this outcome too, because an app may have sent the reply. Raises NoWorkerError if no
    process can be started.
    """
    wall = MonotonicClock()
    problem: RobotcoreError
    try:
        return _unpack(worker.call(_perform_and_pack, request, limit_s=limit_s), request)
    except WorkerEndedError as error:
        problem = BackendError(f"the worker process {error}")
    except NoWorkerError:
        raise
    except (RobotcoreError, TypeError, ValueError) as error:
        worker.close()  # the reply to the next call might be the late reply to this one
        problem = RobotcoreError(f"the worker process gave no result: {error}")
    return build_failed_output(request, problem, wall.now())


def _perform_and_pack(request: RunRequest) -> list[str]:
    """Execute a run, and return its record and picture as texts. Ends the process if the run was interrupted."""
    wall = MonotonicClock()
    try:
        output = perform(request)
    except Exception as error:  # noqa: BLE001  the app or a vendor's library raised it
        output = build_failed_output(request, RobotcoreError(f"{type(error).__name__}: {error}"), wall.now())
    if output.record.result.outcome is Outcome.INTERRUPTED:
        os._exit(output.record.result.exit_status)
    return [output.record.to_json(), b64encode(output.picture or b"").decode("ascii")]


def _unpack(packed: list[str], request: RunRequest) -> RunOutput:
    """Return the output in a reply of `_perform_and_pack`. Raises TypeError or ValueError if it is of another run."""
    line, picture = packed
    record = Record.from_json(line)
    for key, value in _identify(request).items():
        if (received := getattr(record.result, key)) != value and (key, value) != ("world", None):
            raise ValueError(
                f"the reply has {key} {received!r}, not {value!r}. Check which file descriptors the app writes to"
            )
    record = replace(record, command=format_command(request), picture=None)  # an app may have sent others
    return RunOutput(record, b64decode(picture, validate=True) or None)


def _identify(request: RunRequest) -> dict[str, Any]:
    """Return the fields of a result that the request determines, by name."""
    return {
        "app": app_name(request.app_reference),
        "backend": request.backend,
        "robot": load_robot(request.robot).name,
        "world": load_world(request.world).name if request.world else None,
        "seed": request.seed,
    }


def build_failed_output(request: RunRequest, error: RobotcoreError, wall_time_s: float = 0.0) -> RunOutput:
    """Return an output with the outcome ``error`` for a run whose process sent no valid output.

    If the request names a judge, the result says that the run is not verified.

    request: the run.
    error: the reason in the result.
    wall_time_s: the wall time from the start of the run to the error, in seconds; 0 if it is unknown.
    """
    result = replace(_make_error_result(request, error), wall_time_s=round(wall_time_s, 3))
    return RunOutput(Record(shorten(result), None, format_command(request)))


def _make_error_result(request: RunRequest, error: RobotcoreError) -> RunResult:
    conditions: dict[str, float | str] = {}
    with suppress(RobotcoreError):  # the world is invalid
        conditions.update(draw_conditions(request))
    return RunResult(
        **_identify(request),
        outcome=Outcome.ERROR,
        exit_status=error.exit_status,
        reason=str(error),
        verified=False if request.judge else None,
        judge=app_name(request.judge) if request.judge else None,
        conditions=conditions,
        faults=list(request.faults),
    )
