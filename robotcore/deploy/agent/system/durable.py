"""Changes that a power cut does not undo, nor leave half done."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path


def write(path: Path, content: str | bytes) -> None:
    """Replace what is in a file in one step; where that fails, nothing is left of it."""
    beside = _beside(path)
    try:
        with beside.open("wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())
            file.flush()
            os.fsync(file.fileno())
        move(beside, path)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise


def link(path: Path, target: str) -> None:
    """Let a link lead elsewhere in one step; it is made where there is none."""
    beside = _beside(path)
    with suppress(FileNotFoundError):
        beside.unlink()
    beside.symlink_to(target)
    move(beside, path)


def move(source: Path, to: Path) -> None:
    """Rename on the same disk; a file, a link or an empty folder that is there already is replaced."""
    source.replace(to)
    for folder in {source.parent, to.parent}:
        settle(folder)


def settle(folder: Path) -> None:
    """Wait until a folder's own entries are on the disk."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _beside(path: Path) -> Path:
    return path.with_name(f".{path.name}.{os.getpid()}")
