"""A project, changed for a while."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def needing(project: Path, need: str = "six") -> Iterator[None]:
    """Let it need a package, a small one that nothing else needs: no environment on the robot has it."""
    file = project / "pyproject.toml"
    text = file.read_text()
    with rewritten(file, text.replace('version = "0.1.0"', f'version = "0.1.0"\ndependencies = ["{need}"]')):
        yield


@contextmanager
def carrying(project: Path, size_mb: int) -> Iterator[None]:
    """Let it have a file that takes a while to send, for no two bytes of it are alike."""
    file = project / "heavy.bin"
    file.write_bytes(os.urandom(size_mb << 20))
    try:
        yield
    finally:
        file.unlink()


@contextmanager
def rewritten(file: Path, text: str) -> Iterator[None]:
    """Let a file have another text."""
    before = file.read_text()
    file.write_text(text)
    try:
        yield
    finally:
        file.write_text(before)
