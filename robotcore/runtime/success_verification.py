"""Verifies whether a run was a success: the app, or another app, judges the true state of the simulator at its end."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, replace

import numpy as np

from robotcore.errors import BehaviourError, RobotcoreError, UnknownNameError, UsageError
from robotcore.hal.truth import Truth
from robotcore.runtime.apps import app_path, is_app_file, load_app, use_script_folder
from robotcore.runtime.behaviour import Behaviour, require_callable
from robotcore.runtime.result import Outcome
from robotcore.runtime.settings import configure, list_settings


@dataclass(frozen=True)
class Verification:
    """The result of a verification. An unknown value is None."""

    verified: bool | None = None
    """Whether the app and the judge report a success. None if the judge cannot decide it."""
    contacts: int | None = None
    """The number of contacts with obstacles."""
    distance: float | None = None
    """The distance to the target, in metres."""
    failure: BehaviourError | None = None
    """The error that the judge's code raised."""


def verify_run(judge: Behaviour, truth: Truth | None, outcome: Outcome, name: str | None) -> Verification:
    """Verify a run by the true state of the simulator. If the simulator has died, every value of the result is None.

    judge: the app whose ``verify`` decides whether the run was a success.
    name: the judge's name or file. None if the app judges itself.
    """
    if truth is None:
        return Verification()
    try:
        measured = Verification(None, truth.contacts, truth.distance_to_target)
        try:
            verdict = ask_judge(judge, truth, name)
        except BehaviourError as error:
            return replace(measured, failure=error)
        return replace(measured, verified=verdict and outcome is Outcome.SUCCESS)
    except (RobotcoreError, OSError, EOFError):
        return Verification()


def load_judge(name: str) -> Behaviour:
    """Return an app as a judge, with its default settings.

    name: the app's name, or its file.

    Raises UsageError if the app has no ``verify``.
    """
    try:
        judge = load_app(name)
    except UnknownNameError as error:
        raise UsageError(f"--judge: {error}", kind="unknown-judge") from error
    if judge.verify is Behaviour.verify:
        raise UsageError(
            f"--judge {name}: this app cannot judge a run without a method verify. Use another, such as green-search",
            kind="judge-without-verify",
        )
    for setting in list_settings(judge).values():
        if setting.default is MISSING:
            raise UsageError(
                f"--judge {name}: the setting {setting.name} has no default. "
                "Add one, because --set does not apply to the judge",
                kind="judge-setting-missing",
                setting=setting.name,
            )
    return configure(judge, {})


def ask_judge(judge: Behaviour, truth: Truth, name: str | None) -> bool | None:
    """Return the result of the judge's ``verify``: whether the run is a success, or None if the judge cannot decide it.

    name: the judge's name or file. None if the app judges itself.

    Raises BehaviourError if the judge's code raises an exception, or returns neither True, False nor None.
    """
    if name and is_app_file(name):
        use_script_folder(app_path(name))
    try:
        return _call_verify(judge, truth)
    except BehaviourError as error:
        raise (BehaviourError(f"--judge {name}: {error}", kind=error.kind) if name else error) from error.__cause__


def _call_verify(judge: Behaviour, truth: Truth) -> bool | None:
    try:
        verdict: object = judge.verify(truth)
    except RobotcoreError:
        raise
    except (Exception, SystemExit) as error:
        require_callable(judge, "verify")
        raise BehaviourError.from_exception(type(judge), error) from error
    if verdict is None:
        return None
    if isinstance(verdict, (bool, np.bool_)):
        return bool(verdict)
    raise BehaviourError(
        f"{type(judge).__name__}.verify returned {verdict!r:.100}. Return True, False or None", kind="not-a-verdict"
    )
