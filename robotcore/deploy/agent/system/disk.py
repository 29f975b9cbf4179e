"""What room there is, and what takes it."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

MAKE_ROOM = "Make room there: a robot's recordings go home with robotcore deploy fetch --move, df -h tells the rest"
"""What to do about a full disk, at the desk's end too."""


def free_bytes(path: Path) -> int:
    """Return what this user may still write on the disk that a path is on, or will be on."""
    there = next(folder for folder in (path, *path.parents) if folder.exists())
    told = os.statvfs(there)
    return told.f_bavail * told.f_frsize


def size_of(folder: Path) -> int:
    """Return how many bytes all files below a folder take on the disk; those that vanish meanwhile take none."""
    total = 0
    for root, _, files in os.walk(folder):
        for name in files:
            with suppress(OSError):
                total += os.lstat(os.path.join(root, name)).st_blocks * 512  # noqa: PTH118  thousands of files
    return total


def in_words(size: int) -> str:
    """Return a number of bytes as somebody reads it.

    >>> in_words(12_345_678)
    '12.3 MB'
    """
    value = float(size)
    for unit in ("bytes", "kB", "MB"):
        if value < 1000:
            return f"{value:.0f} {unit}" if unit != "MB" else f"{value:.1f} {unit}"
        value /= 1000
    return f"{value:.1f} GB"
