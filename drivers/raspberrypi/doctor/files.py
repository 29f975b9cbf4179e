"""Files in which the kernel tells something."""

from __future__ import annotations

from pathlib import Path


def told(file: Path) -> str:
    """Return what a file tells, without the NUL that ends a string of the device tree; raises OSError."""
    return file.read_text(encoding="utf-8", errors="replace").strip("\0 \n")
