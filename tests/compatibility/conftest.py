"""The versions whose files the tests read: each folder with the name of a version."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

HERE = Path(__file__).parent
VERSIONS = sorted(each.name for each in HERE.iterdir() if each.is_dir() and each.name[0].isdigit())

collect_ignore_glob = ["[0-9]*"]

CopyCorpus = Callable[[str], Path]


@pytest.fixture
def copy_corpus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> CopyCorpus:
    """Return a function that copies the files of a version, and makes the copy the current folder."""

    def copy(version: str) -> Path:
        folder = tmp_path / "corpus"
        shutil.copytree(HERE / version, folder)
        monkeypatch.chdir(folder)
        return folder

    return copy
