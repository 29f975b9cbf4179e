"""Errors of the results folder: a full disk, and a folder that cannot be written."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from robotcore.errors import UsageError
from robotcore.sweep import Results
from robotcore.sweep.single_run import RunOutput
from tests.robotcore.sweep.conftest import make_record, make_sweep
from tests.texts import Raises

SWEEP = make_sweep("green-search", seeds=3)
ENDED = RunOutput(make_record(), None)


def _raise_disk_full(*_: object, **__: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _enter_folder(directory: Path) -> None:
    with Results(SWEEP, directory):
        pass


def test_a_folder_that_cannot_be_made_is_reported(tmp_path: Path, raises: Raises) -> None:
    (tmp_path / "file").touch()
    with raises(UsageError, "unusable-folder", directory=f"{tmp_path}/file/sweep"):
        _enter_folder(tmp_path / "file/sweep")


def test_a_file_in_the_place_of_the_folder_is_reported(tmp_path: Path, raises: Raises) -> None:
    (tmp_path / "file").touch()
    with raises(UsageError, "unusable-folder", directory=f"{tmp_path}/file"):
        _enter_folder(tmp_path / "file")


def test_a_disk_that_is_full_before_the_first_run_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    with monkeypatch.context() as before:
        before.setattr(Path, "replace", _raise_disk_full)
        with raises(UsageError, "unusable-folder", directory=str(tmp_path / "here")):
            _enter_folder(tmp_path / "here")
    assert [file.name for file in (tmp_path / "here").iterdir()] == ["results.jsonl"]
    with Results(SWEEP, tmp_path / "here") as again:
        assert len(again.missing()) == 3


@pytest.mark.parametrize("fresh", [False, True])
def test_a_disk_that_fills_during_the_sweep_is_reported_and_leaves_whole_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fresh: bool, raises: Raises
) -> None:
    file = tmp_path / "results.jsonl"
    with Results(SWEEP, tmp_path, fresh=fresh) as results:
        results.add(ENDED)
        whole = file.read_bytes()
        assert results._journal
        monkeypatch.setattr(results._journal, "_file", _FullDisk(results._journal._file))
        with raises(UsageError, "results-not-written", file=str(tmp_path), resume_hint=results.resume_hint):
            results.add(ENDED)
    assert file.read_bytes() == whole


def test_a_table_that_cannot_be_replaced_is_reported_and_leaves_no_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    def raise_permission_error(source: Path, target: Path) -> None:
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM), str(target))

    with Results(SWEEP, tmp_path) as results:
        results.add(ENDED)
        with monkeypatch.context() as meanwhile:
            meanwhile.setattr(Path, "replace", raise_permission_error)
            with raises(UsageError, "results-not-written", file=str(tmp_path / "results.csv")):
                results.write_tables()
        assert {file.name for file in tmp_path.iterdir()} == {"sweep.json", "results.jsonl"}
        results.write_tables()
    assert (tmp_path / "results.csv").exists()


class _FullDisk:
    """A file on a disk with ten free bytes."""

    def __init__(self, file: object) -> None:
        self._file, self._room = file, 10

    def __getattr__(self, name: str) -> object:
        return getattr(self._file, name)

    def write(self, content: bytes) -> int:
        if not self._room:
            _raise_disk_full()
        written, self._room = self._room, 0
        self._file.write(content[:written])  # type: ignore[attr-defined]
        return written
