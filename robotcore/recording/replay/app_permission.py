"""Decide whether a replay may run the app that a recording names.

A recording may be hostile, so it must not make a replay run an arbitrary file. An app that the user names always runs.
"""

from __future__ import annotations

import os
import shlex
import sys
from collections.abc import Container
from enum import Enum
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from robotcore.errors import RecordingError
from robotcore.plugins import app_names
from robotcore.recording import Recording
from robotcore.recording.codec import to_plain
from robotcore.recording.recording import read_app_source
from robotcore.runtime.apps import app_name, app_path, is_app_file, load_app, load_app_file
from robotcore.runtime.settings import Setting, list_settings
from robotcore.text import escape

_PACKAGES = {"site-packages", "dist-packages"}
_HARMLESS = (int, float, Enum, NoneType)
"""The types of settings whose values cannot be the name of a file, a command or a host."""


LIVE_APP = "LiveApp"
"""The name of the app in the recording of a live robot."""


def require_recorded_app(recording: Recording, file: Path | str, given: Container[str] = ()) -> None:
    """Raise RecordingError if a replay must not run the app that a recording names.

    An installed app may run. A user's file may run if all of this holds:

    - It is below the current folder, and not in a folder of installed packages.
    - Its text is the recorded source.
    - The recording changes none of its settings that can be any text.

    file: the name of the recording in error messages.
    given: the names of the settings that the user sets, so that their recorded values are not used.
    """
    app = recording.metadata.request.app_reference
    called, shown = file or "the recording", escape(app)
    if not is_app_file(app):
        if app == LIVE_APP:
            problem = "it is the recording of a session at a prompt, which has no app"
            remedy = "Read it with robotcore info, or record the run of an app"
            raise RecordingError(called, problem, remedy, kind="session-has-no-app")
        if app_name(app) not in app_names():
            raise RecordingError(
                called,
                f"its app, {shown}, is a class, or an app that is not installed here",
                "Name the file of the app: --app FILE.py",
                kind="app-not-here",
                app=app,
            )
        return
    if not os.path.isfile(app_path(app)):  # noqa: PTH113  it takes any name, however long
        remedy = "Replay it from the folder of the recorded run, or name the app's file: --app FILE.py"
        raise RecordingError(
            called, f"the file of its app, {shown}, does not exist", remedy, kind="app-not-here", app=app
        )
    if problem := _find_problem(recording, given):
        remedy = f"If you trust the app, name it: --app {shlex.quote(shown)}"
        raise RecordingError(
            called,
            f"replay does not run its app, {shown}, because {problem}",
            remedy,
            kind="app-not-permitted",
            app=app,
        )


def is_recorded_app(recording: Recording, app: str) -> bool:
    """Return whether the user's app is the recorded app.

    It has the recorded name, or its file has the name or the source of the recorded file. If the recording names a
    class, the user's app has this class.

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from robotcore import RunRequest, run
    >>> from robotcore.recording import read
    >>> from robotcore.recording.recorder import Recorder
    >>> with TemporaryDirectory() as folder:
    ...     recorder = Recorder(Path(folder, "run.mcap"))
    ...     result = run(RunRequest("avoid-obstacles", timeout_s=0.5), [recorder], [recorder.layer])
    ...     recording = read(Path(folder, "run.mcap"))
    >>> is_recorded_app(recording, "avoid-obstacles"), is_recorded_app(recording, "green-search")
    (True, False)
    """
    recorded = recording.metadata.request.app_reference
    if app_name(app) == app_name(recorded):
        return True
    if is_app_file(recorded):
        classes = {name.partition(":")[2] for name in (app, recorded)} - {""}
        has_same_name = app_path(app).name == app_path(recorded).name
        is_same_file = has_same_name or has_app_changed(recording, app) is False
        return is_app_file(app) and is_same_file and len(classes) <= 1
    return app_name(recorded) not in app_names() and load_app(app).__name__ == recorded


def has_app_changed(recording: Recording, app: str) -> bool | None:
    """Return whether the text of an app's file differs from the recorded source; None if no source was recorded."""
    recorded = recording.metadata.source
    return None if recorded is None else read_app_source(app) != recorded


def _find_problem(recording: Recording, given: Container[str]) -> str:
    """Return why the recorded app's file must not run; empty if it may run.

    The file is imported only for the last check, after all other checks have passed.
    """
    app = recording.metadata.request.app_reference
    path = app_path(app).resolve()
    if not path.is_relative_to(Path.cwd().resolve()):
        return "the file is outside of the current folder"
    if path.is_relative_to(Path(sys.prefix).resolve()) or not _PACKAGES.isdisjoint(path.parts):
        return "the file is in a folder of installed packages"
    if has_app_changed(recording, app) is not False:
        is_known = recording.metadata.source is not None
        return "the file has changed since it was recorded" if is_known else "its source was not recorded"
    if name := _find_open_setting(recording, given):
        return f"the recording changes its setting {escape(repr(name))}, which can be any text"
    return ""


def _find_open_setting(recording: Recording, given: Container[str]) -> str | None:
    """Return the name of a setting that can be any text and that the recording changes; None if there is none."""
    request = recording.metadata.request
    recorded = {name: value for name, value in request.settings.items() if name not in given}
    if all(isinstance(value, (int, float, NoneType)) for value in recorded.values()):
        return None
    known = list_settings(load_app_file(request.app_reference))
    pairs = ((known[name], value) for name, value in recorded.items() if name in known)
    return next((setting.name for setting, value in pairs if _is_open(setting, value)), None)


def _is_open(setting: Setting, value: Any) -> bool:
    return not _is_harmless(setting.type) and value != to_plain(setting.default)


def _is_harmless(kind: Any) -> bool:
    origin = get_origin(kind)
    if origin is Annotated:
        return _is_harmless(get_args(kind)[0])
    if origin in (Union, UnionType):
        return all(map(_is_harmless, get_args(kind)))
    return origin is Literal or (isinstance(kind, type) and issubclass(kind, _HARMLESS))
