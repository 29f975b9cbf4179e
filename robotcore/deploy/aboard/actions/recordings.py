"""Which recordings there are to be fetched."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from robotcore.deploy.aboard.layout import Layout


def act(layout: Layout) -> dict[str, Any]:
    """Return the ``recordings`` by name: ``bytes``, and whether one ``is_being_written``."""
    written = set(_open_files())
    return {"recordings": [_told(path, written) for path in sorted(layout.recordings.glob("*")) if path.is_file()]}


def _told(path: Path, written: set[str]) -> dict[str, Any]:
    is_being_written = os.path.realpath(path) in written
    return {"name": path.name, "bytes": path.stat().st_size, "is_being_written": is_being_written}


def _open_files() -> Iterator[str]:
    """Yield what this user's programs have open."""
    for process in Path("/proc").glob("[0-9]*/fd"):
        with suppress(OSError):
            for handle in process.iterdir():
                with suppress(OSError):
                    yield str(handle.readlink())
