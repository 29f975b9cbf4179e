"""Preflight: import the app and open each backend in a subprocess, so that a crash there is harmless."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager

from robotcore.errors import BackendError, UsageError
from robotcore.hal.backend import load_backend
from robotcore.runtime.apps import IMPORT_ADVICE, app_path, is_app_file, load_app
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.plan import RunRequest
from robotcore.runtime.settings import configure
from robotcore.sweep.spec import Sweep
from robotcore.sweep.worker import WorkerEndedError, WorkerProcess

LOAD_S = 30.0
"""The default time limit for importing an app, in seconds."""

CHECK_S = 300.0
"""The time limit for opening every backend and drawing every world, in seconds."""


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
        with _blame_backends(sweep):
            worker.call(_load_backends, sweep.backends, limit_s=CHECK_S)
        for app in reversed(sweep.apps):
            with _blame_app(app, "imported"):
                worker.call(_import_app, app, limit_s=load_s)
        with _blame_app(sweep.request.app_reference, "made"):
            has_verify = worker.call(_configure_app, sweep.request, limit_s=load_s)
        with _blame_backends(sweep):
            worker.call(sweep.check, limit_s=CHECK_S)  # refuses a judge without verify
    return bool(sweep.request.judge or has_verify)


@contextmanager
def _blame_app(app: str, step: str) -> Iterator[None]:
    """Raise UsageError if the app's code ends its process or hangs when the app is ``step``, such as ``imported``."""
    try:
        yield
    except WorkerEndedError as error:
        name = app_path(app) if is_app_file(app) else app
        problem = f"when {name} was {step}, its process {error}"
        raise UsageError(f"{problem}. {IMPORT_ADVICE}", kind="app-ends-process", app=app, step=step) from error


@contextmanager
def _blame_backends(sweep: Sweep) -> Iterator[None]:
    """Raise BackendError if the backends' code ends its process or hangs."""
    try:
        yield
    except WorkerEndedError as error:
        names = f"the backend{'s' * (len(sweep.backends) > 1)} {', '.join(sweep.backends)}"
        raise BackendError(
            f"the process that opened {names} {error}. Try each backend alone: robotcore run APP --backend NAME",
            kind="backend-ends-process",
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
