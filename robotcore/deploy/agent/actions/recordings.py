"""Which recordings there are to be fetched."""

from __future__ import annotations

import os
import stat
from collections.abc import Container, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from robotcore.deploy.agent.layout import Layout


def act(layout: Layout) -> dict[str, Any]:
    """Return the ``recordings``: ``name``, ``bytes``, whether one ``is_file``, and whether one ``is_being_written``.

    Links, folders and devices are listed too, so that the desk can name what it leaves here. An empty file, as a full
    disk leaves it, is not.
    """
    written = open_files()
    listed = [_describe(path, written) for path in sorted(layout.recordings.glob("*"))]
    return {"recordings": [each for each in listed if each["bytes"] or each["is_being_written"] or not each["is_file"]]}


def open_files() -> set[str]:
    """Return the files that this user's programs have open."""
    return set(_open_files())


def _describe(path: Path, written: Container[str]) -> dict[str, Any]:
    status = path.lstat()
    return {
        "name": os.fsencode(path.name).decode(errors="backslashreplace"),
        "bytes": status.st_size,
        "is_file": stat.S_ISREG(status.st_mode),
        "is_being_written": str(path.resolve()) in written,
    }


def _open_files() -> Iterator[str]:
    for process in Path("/proc").glob("[0-9]*/fd"):
        with suppress(OSError):
            for handle in process.iterdir():
                with suppress(OSError):
                    yield str(handle.readlink())
