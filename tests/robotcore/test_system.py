"""The errors and notes of a system that lacks POSIX or Linux."""

from __future__ import annotations

from pathlib import Path

import pytest

from robotcore import files, system
from robotcore.errors import UnsupportedSystemError, UsageError
from robotcore.files import lock_file
from robotcore.recording.segments import open_locked
from robotcore.runtime import active_runs
from robotcore.runtime.active_runs import list_active_runs, register_run
from robotcore.sweep.results_file import Journal
from tests.texts import Raises


def test_stop_without_proc_names_the_way_that_works(monkeypatch: pytest.MonkeyPatch, raises: Raises) -> None:
    monkeypatch.setattr(system, "IS_LINUX", False)
    with raises(UnsupportedSystemError, "unsupported-system"):
        list_active_runs()


def test_a_run_without_proc_is_not_registered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(active_runs, "IS_LINUX", False)
    with pytest.raises(OSError, match="no /proc"), register_run("serial", "rover", {}):
        pass


def test_what_posix_has_is_not_refused() -> None:
    system.require_posix("a test", "POSIX", "Nothing") if system.HAS_POSIX else None
    system.require_linux("a test", "Linux", "Nothing") if system.IS_LINUX else None


def test_a_lock_excludes_a_second_one_and_not_a_reader(tmp_path: Path) -> None:
    file = tmp_path / "a.mcap"
    file.write_bytes(b"content")
    with open_locked(file) as locked:
        assert locked.tell() == 0
        with pytest.raises(BlockingIOError), file.open("r+b", buffering=0) as other:
            lock_file(other)
        assert file.read_bytes() == b"content"
    with open_locked(file):
        pass  # the end of the first one released the lock


def test_two_sweeps_cannot_write_into_one_folder(tmp_path: Path, raises: Raises) -> None:
    journal = Journal(tmp_path / "results.jsonl")
    with raises(UsageError, "sweep-locked"):
        Journal(tmp_path / "results.jsonl")
    journal.append("a")
    journal.close()
    assert (tmp_path / "results.jsonl").read_bytes() == b"a\n"


def test_free_space_is_that_of_the_disk_of_the_file(tmp_path: Path) -> None:
    with (tmp_path / "a").open("wb", buffering=0) as file:
        assert files.measure_free_space(file) > 0
