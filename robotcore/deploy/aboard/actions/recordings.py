"""Which recordings there are to be fetched."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from robotcore.deploy.aboard.layout import Layout
from robotcore.deploy.aboard.system.digest import sha256


def act(layout: Layout, *, hashed: Sequence[str] = ()) -> dict[str, Any]:
    """Return the ``recordings``: ``name``, ``bytes``, and whether one ``is_being_written``.

    One that nothing was written into, as where the disk was full, is none. Those named in ``hashed`` are read, and have
    their ``sha256`` besides; names that are not there are passed over.
    """
    written = set(_open_files())
    files = [path for path in sorted(layout.recordings.glob("*")) if path.is_file()]
    told = [_told(path, written, is_hashed=path.name in hashed) for path in files]
    return {"recordings": [each for each in told if each["bytes"] or each["is_being_written"]]}


def _told(path: Path, written: Container[str], *, is_hashed: bool) -> dict[str, Any]:
    told = {"name": path.name, "bytes": path.stat().st_size, "is_being_written": str(path.resolve()) in written}
    return {**told, "sha256": sha256(path)} if is_hashed else told


def _open_files() -> Iterator[str]:
    """Yield what this user's programs have open."""
    for process in Path("/proc").glob("[0-9]*/fd"):
        with suppress(OSError):
            for handle in process.iterdir():
                with suppress(OSError):
                    yield str(handle.readlink())
