"""The shipped files as text, to be changed; and what is said of a file that is wrong."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import pytest

from robotcore.description import load_any
from robotcore.errors import DescriptionError

SHIPPED = resources.files("robotcore.description")
ROVER = SHIPPED.joinpath("robots", "rover.toml").read_text(encoding="utf-8")
ARENA = SHIPPED.joinpath("worlds", "arena.toml").read_text(encoding="utf-8")


def values(tmp_path: Path, content: str | bytes) -> str:
    """Return the one line that is said about a file with this content, from the key on."""
    (error,) = errors(tmp_path, content)
    line = str(error)
    assert line.startswith(f"{error.file}: ")
    assert "\n" not in line
    return line.removeprefix(f"{error.file}: ")


def errors(tmp_path: Path, content: str | bytes) -> list[DescriptionError]:
    """Return all that is said about a file with this content, the first with no line for the others."""
    file = tmp_path / "my.toml"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(DescriptionError) as caught:
        load_any(str(file))
    error = caught.value
    return [DescriptionError(error.file, error.key, error.fault, error.remedy), *error.others]


def changed(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)
