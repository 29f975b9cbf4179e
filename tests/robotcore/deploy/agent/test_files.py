from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from robotcore.deploy.agent import files


def test_a_file_is_replaced_and_nothing_is_left_beside_it(tmp_path: Path) -> None:
    file = tmp_path / "trial.json"
    files.write_file(file, "old")
    files.write_file(file, "new")
    assert [path.name for path in tmp_path.iterdir()] == ["trial.json"]
    assert file.read_text() == "new"


def test_what_cannot_be_written_leaves_what_was_there_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def is_full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    file = tmp_path / "trial.json"
    files.write_file(file, "old")
    monkeypatch.setattr(os, "fsync", is_full)
    with pytest.raises(OSError, match=os.strerror(errno.ENOSPC)):
        files.write_file(file, "new")
    assert [(path.name, path.read_text()) for path in tmp_path.iterdir()] == [("trial.json", "old")]


def test_a_link_leads_elsewhere_though_somebody_was_killed_in_the_middle_before(tmp_path: Path) -> None:
    link = tmp_path / "current"
    files.replace_link(link, "releases/old")
    tmp_path.joinpath(f".current.{os.getpid()}").symlink_to("releases/half")
    files.replace_link(link, "releases/new")
    assert [(path.name, str(path.readlink())) for path in tmp_path.iterdir()] == [("current", "releases/new")]


def test_content_is_on_the_disk_before_the_name_and_the_folder_after_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[tuple[str, bool]] = []
    file, real = tmp_path / "trial.json", os.fsync

    def noted(handle: int) -> None:
        seen.append((Path(f"/proc/self/fd/{handle}").readlink().name, file.exists()))
        real(handle)

    monkeypatch.setattr(os, "fsync", noted)
    files.write_file(file, "new")
    assert seen == [(f".trial.json.{os.getpid()}", False), (tmp_path.name, True)]
