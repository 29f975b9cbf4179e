"""The user's own files that a sweep reads: an app and its judge with the modules beside them, a robot, worlds."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from robotcore.description import is_own
from robotcore.errors import UsageError
from robotcore.runtime.apps import app_path, is_app_file
from robotcore.sweep.spec import Sweep


def own_files(sweep: Sweep) -> dict[Path, bytes]:
    """Return the files by their absolute paths, in order, with what is in them."""
    return {file: _content(file) for file in sorted(set(_files(sweep)))}


def _files(sweep: Sweep) -> Iterator[Path]:
    for name in filter(is_app_file, sweep.apps):
        app = app_path(name).absolute()
        yield from (app, *filter(_is_module, app.parent.glob("*.py")))
    yield from (Path(name).absolute() for name in (sweep.request.robot, *sweep.worlds) if is_own(name))


def _is_module(file: Path) -> bool:
    """Return whether it can be imported; the lock of an editor (``.#app.py``) or a folder cannot."""
    return file.is_file() and not file.name.startswith(".")


def _content(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise UsageError(f"{file}: {error.strerror}. Name a file that can be read") from error
