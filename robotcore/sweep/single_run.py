"""Execute one run of a sweep, in this process or in a worker process."""

from __future__ import annotations

import os
from base64 import b64decode, b64encode
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from robotcore.errors import RobotcoreError
    from robotcore.runtime.plan import RunRequest
    from robotcore.runtime.result import RunResult
    from robotcore.sweep.record import Record
    from robotcore.sweep.worker import WorkerProcess


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
    from robotcore.errors import RobotcoreError
    from robotcore.runtime.session import run
    from robotcore.sweep.record import PathRecorder, Record, shorten
    from robotcore.sweep.spec import format_command
    from robotcore.view.picture import PictureRecorder

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
    from robotcore.errors import BackendError, RobotcoreError
    from robotcore.hal.wall_clock import MonotonicClock
    from robotcore.sweep.worker import NoWorkerError, WorkerDiedError, WorkerHungError

    wall = MonotonicClock()
    try:
        return _unpack(worker.call(_perform_and_pack, request, limit_s=limit_s), request)
    except WorkerDiedError as error:
        return make_failed_output(request, BackendError(f"the worker process died: {error}"), wall.now())
    except WorkerHungError as error:
        return make_failed_output(request, BackendError(f"hung: {error}"), wall.now())
    except NoWorkerError:
        raise
    except (RobotcoreError, TypeError, ValueError) as error:
        worker.close()  # the reply to the next call might be the late reply to this one
        problem = RobotcoreError(f"the worker process gave no result: {error}")
        return make_failed_output(request, problem, wall.now())


def _perform_and_pack(request: RunRequest) -> list[str]:
    output = _perform_or_exit(request)
    return [output.record.to_json(), b64encode(output.picture or b"").decode("ascii")]


def _unpack(packed: list[str], request: RunRequest) -> RunOutput:
    """Return the output in a reply of `_perform_and_pack`. Raises TypeError or ValueError if it is of another run."""
    from robotcore.sweep.record import Record
    from robotcore.sweep.spec import format_command

    line, picture = packed
    record = Record.from_json(line)
    _require_same_run(request, record.result)
    return RunOutput(
        replace(record, command=format_command(request), picture=None), b64decode(picture, validate=True) or None
    )


def _require_same_run(request: RunRequest, result: RunResult) -> None:
    from robotcore.description import load_robot, load_world
    from robotcore.runtime.apps import app_name

    asked = {
        "app": app_name(request.app_reference),
        "backend": request.backend,
        "robot": load_robot(request.robot).name,
        "world": load_world(request.world).name if request.world else result.world,
        "seed": request.seed,
    }
    for key, value in asked.items():
        if (received := getattr(result, key)) != value:
            raise ValueError(
                f"the reply has {key} {received!r}, not {value!r}. Check which file descriptors the app writes to"
            )


def _perform_or_exit(request: RunRequest) -> RunOutput:
    """Execute a run. Ends the process if the run was interrupted. After any exception, the outcome is ``error``."""
    from robotcore.errors import RobotcoreError
    from robotcore.hal.wall_clock import MonotonicClock
    from robotcore.runtime.result import Outcome

    wall = MonotonicClock()
    try:
        output = perform(request)
    except Exception as error:  # noqa: BLE001  the app or a vendor's library raised it
        return make_failed_output(request, RobotcoreError(f"{type(error).__name__}: {error}"), wall.now())
    if output.record.result.outcome is Outcome.INTERRUPTED:
        os._exit(output.record.result.exit_status)
    return output


def make_failed_output(request: RunRequest, error: RobotcoreError, wall_time_s: float = 0.0) -> RunOutput:
    """Return an output with the outcome ``error`` for a run whose process sent no valid output.

    If the request names a judge, the result says that the run is not verified.

    request: the run.
    error: the reason in the result.
    wall_time_s: the wall time from the start of the run to the error, in seconds; 0 if it is unknown.
    """
    from robotcore.sweep.record import Record, shorten
    from robotcore.sweep.spec import format_command

    result = replace(_make_error_result(request, error), wall_time_s=round(wall_time_s, 3))
    return RunOutput(Record(shorten(result), None, format_command(request)))


def _make_error_result(request: RunRequest, error: RobotcoreError) -> RunResult:
    from robotcore.description import load_robot, load_world
    from robotcore.runtime.apps import app_name
    from robotcore.runtime.result import Outcome, RunResult

    return RunResult(
        app=app_name(request.app_reference),
        backend=request.backend,
        robot=load_robot(request.robot).name,
        world=load_world(request.world).name if request.world else None,
        seed=request.seed,
        outcome=Outcome.ERROR,
        exit_status=error.exit_status,
        reason=str(error),
        verified=False if request.judge else None,
        judge=app_name(request.judge) if request.judge else None,
        conditions=_draw_conditions(request),
        faults=list(request.faults),
    )


def _draw_conditions(request: RunRequest) -> dict[str, float | str]:
    """Return the conditions that the run's seed draws; an empty dict if the world is invalid."""
    from robotcore.errors import RobotcoreError
    from robotcore.runtime.plan import draw_conditions

    with suppress(RobotcoreError):
        return dict(draw_conditions(request))
    return {}
