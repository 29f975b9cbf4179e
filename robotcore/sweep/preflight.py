"""Preflight: import the app and open each backend in a subprocess, so that a crash there is harmless."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from typing import Any

from robotcore.errors import BackendError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.runtime.apps import IMPORT_ADVICE, app_path, is_app_file, load_app
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.settings import configure
from robotcore.sweep.spec import Sweep
from robotcore.sweep.worker import WorkerDiedError, WorkerHungError, WorkerProcess

LOAD_S = 30.0
"""The default time limit for importing an app, in seconds."""

CHECK_S = 300.0
"""The time limit for opening every backend and drawing every world, in seconds."""

_REMEDY = "Try each backend alone: robotcore run APP --backend NAME"


def preflight(sweep: Sweep, load_s: float = LOAD_S) -> bool:
    """Run `Sweep.check` in another process, and return whether the app or the judge has a method ``verify``.

    This process imports none of the user's code.

    sweep: the sweep to check.
    load_s: the time limit for importing an app, in seconds.

    Raises the errors of `Sweep.check`. Raises UsageError if an app ends the process or hangs, and BackendError if a
    backend ends the process or hangs.
    """
    # Backends are imported before the app, as in a run. A module in the app's folder may have the name of a package.
    with closing(WorkerProcess()) as worker:
        _call_backends(worker, sweep, _load_backends, sweep.backends)
        for app in reversed(sweep.apps):
            _call_app(worker, app, "imported", load_s, _import_app, app)
        has_verify = _call_app(worker, sweep.request.app_reference, "made", load_s, _configure_app, sweep.request)
        _call_backends(worker, sweep, sweep.check)  # refuses a judge without verify
    return bool(sweep.request.judge or has_verify)


def _call_app(
    worker: WorkerProcess,
    app: str,
    step: str,
    limit_s: float,
    function: Callable[..., object],
    argument: RunRequest | str,
) -> Any:
    """Call a function that runs the app's code, and return its result. Raise UsageError if it does not return.

    step: the app's step in messages, a participle such as ``imported``.
    """
    try:
        return worker.call(function, argument, limit_s=limit_s)
    except WorkerDiedError as error:
        problem = f"ends its process when it is {step} ({error})"
        kind = "app-ends-process"
    except WorkerHungError:
        problem = f"hangs when it is {step}: not done after {limit_s:g} s"
        kind = "app-hangs"
    name = app_path(app) if is_app_file(app) else app
    raise UsageError(f"{name} {problem}. {IMPORT_ADVICE}", kind=kind, app=app, step=step)


def _call_backends(worker: WorkerProcess, sweep: Sweep, function: Callable[..., None], *arguments: object) -> None:
    """Call a function that runs the backends' code. Raise BackendError if the function does not return."""
    try:
        worker.call(function, *arguments, limit_s=CHECK_S)
    except WorkerDiedError as error:
        raise BackendError(
            f"the process that opened {_format_backends(sweep)} died: {error}. {_REMEDY}",
            kind="backend-died",
            backends=list(sweep.backends),
        ) from error
    except WorkerHungError as error:
        raise BackendError(
            f"{_format_backends(sweep)} cannot be opened: {error}. {_REMEDY}",
            kind="backend-hangs",
            backends=list(sweep.backends),
        ) from error


def _load_backends(names: Sequence[str]) -> None:
    for name in names:
        load_backend(name)


def _import_app(app: str) -> None:
    load_app(app)


def _configure_app(request: RunRequest) -> bool:
    app = configure(load_app(request.app_reference), request.settings)
    return type(app).verify is not Behaviour.verify


def _format_backends(sweep: Sweep) -> str:
    return f"the backend{'s' * (len(sweep.backends) > 1)} {', '.join(sweep.backends)}"
