from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from robotcore.deploy.agent import files


def test_file_is_replaced_without_leftovers(tmp_path: Path) -> None:
    file = tmp_path / "trial.json"
    files.write_file(file, "old")
    files.write_file(file, "new")
    assert [path.name for path in tmp_path.iterdir()] == ["trial.json"]
    assert file.read_text() == "new"


def test_failed_write_keeps_the_old_content(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def is_full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    file = tmp_path / "trial.json"
    files.write_file(file, "old")
    monkeypatch.setattr(os, "fsync", is_full)
    with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)):
        files.write_file(file, "new")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("trial.json", "old")]


def test_link_is_replaced_after_an_interrupted_attempt(tmp_path: Path) -> None:
    link = tmp_path / "current"
    files.replace_link(link, "releases/old")
    tmp_path.joinpath(f".current.{os.getpid()}").symlink_to("releases/half")
    files.replace_link(link, "releases/new")
    assert [(path.name, str(path.readlink())) for path in tmp_path.iterdir()] == [("current", "releases/new")]


def test_content_is_synced_before_the_rename_and_the_folder_after_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[tuple[str, bool]] = []
    file, real = tmp_path / "trial.json", os.fsync

    def record_sync(handle: int) -> None:
        seen.append((Path(f"/proc/self/fd/{handle}").readlink().name, file.exists()))
        real(handle)

    monkeypatch.setattr(os, "fsync", record_sync)
    files.write_file(file, "new")
    assert seen == [(f".trial.json.{os.getpid()}", False), (tmp_path.name, True)]
