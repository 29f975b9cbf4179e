"""Verification of a run's end by the simulator's truth: by the app itself, or by another app as the judge."""

from __future__ import annotations

from dataclasses import MISSING, dataclass, replace

from robotcore.errors import BehaviourError, RobotcoreError, UnknownNameError, UsageError
from robotcore.hal.truth import Truth
from robotcore.runtime.apps import app_path, is_app_file, load_app, use_script_folder
from robotcore.runtime.behaviour import Behaviour
from robotcore.runtime.result import Outcome
from robotcore.runtime.settings import configure, settings_of


@dataclass(frozen=True)
class Verification:
    """What the truth says at the end; None is what nobody knows. ``failure`` is what the judge's own code raised."""

    verified: bool | None = None
    contacts: int | None = None
    distance: float | None = None
    failure: BehaviourError | None = None


def verify_run(judge: Behaviour, truth: Truth | None, outcome: Outcome, name: str | None) -> Verification:
    """Verify a run by the simulator's truth. If the simulator has died, every value is None."""
    if truth is None:
        return Verification()
    try:
        measured = Verification(None, truth.contacts, truth.distance_to_target)
        try:
            said = ask_judge(judge, truth, name)
        except BehaviourError as error:
            return replace(measured, failure=error)
        return replace(measured, verified=said and outcome is Outcome.SUCCESS)
    except (RobotcoreError, OSError, EOFError):
        return Verification()


def load_judge(name: str) -> Behaviour:
    """Return the app that is to judge, with its default settings; UsageError where it would judge nothing."""
    try:
        judge = load_app(name)
    except UnknownNameError as error:
        raise UsageError(f"--judge: {error}") from error
    if judge.verify is Behaviour.verify:
        raise UsageError(
            f"--judge {name}: it has no verify, so it judges nothing. Name an app that has one, such as green-search"
        )
    for setting in settings_of(judge).values():
        if setting.default is MISSING:
            raise UsageError(
                f"--judge {name}: its setting {setting.name} has no default. Give it one: --set is the app's"
            )
    return configure(judge, {})


def ask_judge(judge: Behaviour, truth: Truth, name: str | None) -> bool | None:
    """Return what the judge says; ``name`` is what it was asked for by, None where an app judges itself.

    Raises BehaviourError where its own code raises.
    """
    if name and is_app_file(name):
        use_script_folder(app_path(name))
    try:
        said = judge.verify(truth)
        return None if said is None else bool(said)  # an array of several has no truth
    except RobotcoreError:
        raise
    except (Exception, SystemExit) as error:
        raised = BehaviourError.raised_by(type(judge), error)
        raise (BehaviourError(f"--judge {name}: {raised}") if name else raised) from error
