"""What a command is to write into, looked at before anything is touched."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from robotcore.errors import UsageError


def require_apart(option: str, output: Path | None, *inputs: Path | str) -> None:
    """Raise UsageError where an output is a file that the command reads, by whatever name or link."""
    if output and any(is_same(output, file) for file in inputs):
        raise UsageError(f"{option} {output}: this is the file that is read. Name another one")


def require_ending(option: str, output: Path | None, endings: Collection[str]) -> None:
    """Raise UsageError where an output is to be written under an ending of another kind of file; a folder has none."""
    if output and not output.is_dir() and output.suffix.lower() not in endings:
        raise UsageError(f"{option} {output}: it is written as {' or '.join(endings)}. Give it that ending")


def is_same(file: Path, named: Path | str) -> bool:
    """Return whether both are there, and one file."""
    try:
        return file.samefile(named)
    except (OSError, ValueError):
        return False
