"""The text of two shipped files, and a function that returns the errors of a file."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import pytest

from robotcore.description import load_any
from robotcore.errors import DescriptionError

SHIPPED = resources.files("robotcore.description")
ROVER = SHIPPED.joinpath("robots", "rover.toml").read_text(encoding="utf-8")
ARENA = SHIPPED.joinpath("worlds", "arena.toml").read_text(encoding="utf-8")


def find_errors(tmp_path: Path, content: str | bytes) -> list[DescriptionError]:
    """Load a file with a content that has mistakes. Return an error for each mistake."""
    file = tmp_path / "my.toml"
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(DescriptionError) as caught:
        load_any(str(file))
    error = caught.value
    found = [DescriptionError(error.file, error.key, error.problem, error.remedy, kind=error.kind), *error.others]
    assert str(error).count("\n") == len(error.others)
    assert not any("\n" in str(each) for each in found)
    return found


def replace(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)
