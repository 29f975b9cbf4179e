"""Which recordings there are to be fetched."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from robotcore.deploy.aboard.digest import sha256
from robotcore.deploy.aboard.layout import Layout


def act(layout: Layout, *, hashed: Collection[str] = ()) -> dict[str, Any]:
    """Return the ``recordings`` by name: ``bytes``, whether one ``is_being_written``, and ``sha256`` of those named."""
    written = set(_open_files())
    files = [path for path in sorted(layout.recordings.glob("*")) if path.is_file()]
    return {"recordings": [{**_told(path, written), **_digest(path, hashed)} for path in files]}


def _told(path: Path, written: set[str]) -> dict[str, Any]:
    is_being_written = os.path.realpath(path) in written
    return {"name": path.name, "bytes": path.stat().st_size, "is_being_written": is_being_written}


def _digest(path: Path, hashed: Collection[str]) -> dict[str, str]:
    return {"sha256": sha256(path)} if path.name in hashed else {}


def _open_files() -> Iterator[str]:
    """Yield what this user's programs have open."""
    for process in Path("/proc").glob("[0-9]*/fd"):
        with suppress(OSError):
            for handle in process.iterdir():
                with suppress(OSError):
                    yield str(handle.readlink())
