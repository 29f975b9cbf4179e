"""Changes that a power cut does not undo, nor leave half done."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path


def write(path: Path, text: str) -> None:
    """Replace a file's text in one step."""
    beside = _beside(path)
    with beside.open("w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    move(beside, path)


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
