"""Names of the user's files: where they are in the project, and in messages."""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path

from robotcore.errors import UsageError
from robotcore.runtime.apps import is_app_file
from robotcore.text import escape

MOST_NAMED = 5
"""So many files are named in a message."""


def inside(folder: Path, base: Path, name: str, kind: str) -> str:
    """Return a file, named from ``base``, as its project's folder calls it; what stands behind a colon stays.

    It is a file to whoever reads it: ``./`` goes before what could be taken for an option or for something installed.
    Raises UsageError where it is not there, or outside of the folder: only what is inside is sent.
    """
    path, colon, rest = name.partition(":") if is_app_file(name) else (name, "", "")
    file = Path(os.path.normpath(base / path))
    if not file.is_file():
        raise UsageError(f"{escape(name)}: there is no such file. Name the {kind}'s file, or one that is installed")
    file = file.parent.resolve() / file.name
    if not file.is_relative_to(folder):
        raise UsageError(
            f"{escape(name)} is outside of {escape(str(folder))}, and only what is in there is sent. Move the {kind} "
            "into it, or name a folder that has both: --project DIR"
        )
    there = file.relative_to(folder).as_posix()
    is_plain = there.endswith((".py", ".toml")) and not there.startswith("-")
    return f"{'' if is_plain else './'}{there}{colon}{rest}"


def require_sendable(folder: Path) -> None:
    """Refuse, by UsageError, a folder that nobody means to send whole: the home, or what is above it."""
    if Path.home().resolve().is_relative_to(folder.resolve()):
        raise UsageError(
            f"{escape(str(folder))} would be sent whole, with all that is in your home. Make a folder for the project "
            "and put its files there: robotcore new"
        )


def list_names(names: Collection[str], most: int = MOST_NAMED) -> str:
    """Return the first names, escaped, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"{', '.join(map(escape, list(names)[:most]))}{more}"
