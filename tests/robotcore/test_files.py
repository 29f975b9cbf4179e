"""Atomic replacement of files."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from robotcore.files import find_parts, replace_file, replace_text


def test_the_old_content_stays_if_the_new_file_cannot_be_written(tmp_path: Path) -> None:
    file = tmp_path / "table.csv"
    file.write_text("whole\n")
    with pytest.raises(OSError) as raised, replace_text(file) as text:  # noqa: PT011, PT012  the errno is asserted
        text.write("half")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert raised.value.errno == errno.ENOSPC
    assert file.read_text() == "whole\n"
    assert [each.name for each in tmp_path.iterdir()] == ["table.csv"]


def test_the_text_is_on_the_disk_before_it_replaces_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[int] = []
    monkeypatch.setattr(os, "fsync", lambda file: synced.append(os.fstat(file).st_size))
    with replace_text(tmp_path / "table.csv") as text:
        text.write("whole\n")
    assert synced == [6]
    assert (tmp_path / "table.csv").read_text() == "whole\n"


def test_an_error_names_the_file_and_not_the_new_one(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as raised, replace_file(tmp_path / "run.png") as part:
        part.unlink()
    assert raised.value.filename == str(tmp_path / "run.png")


def test_the_new_file_of_a_killed_process_is_found(tmp_path: Path) -> None:
    (tmp_path / "results.jsonl").touch()
    with replace_file(tmp_path / "sweep.json") as part:
        assert find_parts(tmp_path) == [part]
        part.touch()
    assert find_parts(tmp_path) == []
