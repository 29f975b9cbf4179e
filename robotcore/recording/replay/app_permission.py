"""Decide whether the app that a recording names may run.

A recording may come from anybody, so it must not make a replay run an arbitrary file. If the user names the app's
file, that file runs with any recording.
"""

from __future__ import annotations

import shlex
import sys
from collections.abc import Container
from enum import Enum
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from robotcore.errors import RecordingError
from robotcore.recording import Recording
from robotcore.recording.codec import to_plain
from robotcore.recording.recording import read_app_source
from robotcore.runtime.apps import app_path, is_app_file, load_app_file
from robotcore.runtime.settings import Setting, list_settings
from robotcore.text import escape

_PACKAGES = {"site-packages", "dist-packages"}
_HARMLESS = (int, float, Enum, NoneType)
"""Types of settings whose values cannot name a file, a command or a host."""


def require_recorded_app(recording: Recording, file: Path | str, given: Container[str] = ()) -> None:
    """Raise RecordingError if the recorded app must not run unless the user names it.

    An installed app may run. A user's file may run if it is below the current folder and not among installed packages.
    Its text must be the recorded one, and the recording must not set a setting of the app to a free text.

    file: the name of the recording in error messages.
    given: the names of the settings that the user sets. Their values do not come from the recording.
    """
    app = recording.metadata.request.app
    if not is_app_file(app):
        return
    called, shown = file or "the recording", escape(app)
    if not app_path(app).is_file():
        remedy = "Replay it from the folder that it was run in, or name the app's file: --app FILE.py"
        raise RecordingError(called, f"its app, {shown}, is not here", remedy, kind="app-not-here", app=app)
    if problem := _find_problem(recording, given):
        remedy = f"To run it, name it: --app {shlex.quote(shown)}"
        raise RecordingError(
            called, f"its app, {shown}, {problem}, so replay did not run it", remedy, kind="app-not-permitted", app=app
        )


def is_recorded_file(recording: Recording, app: str) -> bool:
    """Return whether ``app`` is the file of the recorded app. Its name or its text must be the recorded one."""
    recorded = recording.metadata.request.app
    if not (is_app_file(app) and is_app_file(recorded)):
        return False
    return app_path(app).name == app_path(recorded).name or has_app_changed(recording, app) is False


def has_app_changed(recording: Recording, app: str) -> bool | None:
    """Return whether the text of a file differs from the recorded text; None if no text was recorded."""
    recorded = recording.metadata.source
    return None if recorded is None else read_app_source(app) != recorded


def _find_problem(recording: Recording, given: Container[str]) -> str:
    """Return why the recorded app's file must not run; empty if it may. All other checks precede its import."""
    app = recording.metadata.request.app
    path = app_path(app).resolve()
    if not path.is_relative_to(Path.cwd().resolve()):
        return "is outside of the current folder"
    if path.is_relative_to(Path(sys.prefix).resolve()) or not _PACKAGES.isdisjoint(path.parts):
        return "is among installed packages"
    if has_app_changed(recording, app) is not False:
        is_known = recording.metadata.source is not None
        return "has changed since it was recorded" if is_known else "was recorded without its text"
    if name := _find_open_setting(recording, given):
        return f"would get the setting {escape(repr(name))} from the recording, which is no number and no fixed choice"
    return ""


def _find_open_setting(recording: Recording, given: Container[str]) -> str | None:
    """Return the name of a setting that the recording sets to a free text other than the app's default; else None."""
    request = recording.metadata.request
    recorded = {name: value for name, value in request.settings.items() if name not in given}
    if all(isinstance(value, (int, float, NoneType)) for value in recorded.values()):
        return None
    known = list_settings(load_app_file(request.app))
    pairs = ((known[name], value) for name, value in recorded.items() if name in known)
    return next((setting.name for setting, value in pairs if _is_open(setting, value)), None)


def _is_open(setting: Setting, value: Any) -> bool:
    return not _is_harmless(setting.type) and value != to_plain(setting.default)


def _is_harmless(kind: Any) -> bool:
    """Return whether each value of a type is a number, a boolean, None, or one of a fixed set."""
    origin = get_origin(kind)
    if origin is Annotated:
        return _is_harmless(get_args(kind)[0])
    if origin in (Union, UnionType):
        return all(map(_is_harmless, get_args(kind)))
    return origin is Literal or (isinstance(kind, type) and issubclass(kind, _HARMLESS))
