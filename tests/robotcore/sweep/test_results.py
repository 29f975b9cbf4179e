"""The results folder of a sweep: missing runs, torn lines, locks, other seeds, and a full disk."""

from __future__ import annotations

import csv
import errno
import os
from dataclasses import replace
from pathlib import Path
from unittest.mock import Mock

import pytest

from robotcore import Outcome
from robotcore.errors import UsageError
from robotcore.sweep import Results, Sweep
from robotcore.sweep.single_run import RunOutput
from robotcore.sweep.spec import format_command
from tests.robotcore.sweep.conftest import AppFile, make_record, make_sweep
from tests.texts import Raises

SWEEP = make_sweep("green-search", seeds=3)
LONG_AGO_NS = 10**18
ENDED = RunOutput(make_record(), None)


def _make_output(seed: int, outcome: Outcome = Outcome.SUCCESS, picture: bytes | None = None) -> RunOutput:
    command = format_command(list(SWEEP.requests())[seed - 1])
    return RunOutput(replace(make_record(outcome, seed=seed), command=command), picture)


def _write_results(directory: Path, *seeds: int, with_tables: bool = False) -> Path:
    with Results(SWEEP, directory) as results:
        for seed in seeds:
            results.add(_make_output(seed))
        if with_tables:
            results.write_tables()
    return directory / "results.jsonl"


def _list_seeds(directory: Path, sweep: Sweep = SWEEP) -> tuple[list[int | None], list[int | None]]:
    """Return the seeds that have a record, and those that are missing."""
    with Results(sweep, directory) as results:
        return [each.result.seed for each in results.records()], [each.seed for each in results.missing()]


def _read_seeds_of_table(directory: Path) -> list[str]:
    with (directory / "results.csv").open(newline="") as table:
        return [row["seed"] for row in csv.DictReader(table)]


def test_a_torn_last_line_is_deleted_and_its_run_repeated(tmp_path: Path) -> None:
    file = _write_results(tmp_path, 1, 2)
    file.write_bytes(file.read_bytes()[:-40])
    with Results(SWEEP, tmp_path) as again:
        assert [request.seed for request in again.missing()] == [2, 3]
        again.add(_make_output(3))
        assert [record.result.seed for record in again.records()] == [1, 3]


def test_a_picture_is_named_by_its_record_and_fresh_deletes_both(tmp_path: Path) -> None:
    with Results(SWEEP, tmp_path) as results:
        results.add(_make_output(1, Outcome.TIMEOUT, b"png"))
        (record,) = results.records()
    picture = tmp_path / "failures" / "kinematic-open-1.png"
    assert (record.picture, picture.read_bytes()) == ("failures/kinematic-open-1.png", b"png")
    with Results(SWEEP, tmp_path, deletes_old_results=True) as again:
        assert len(again.missing()) == 3
    assert not picture.exists()


@pytest.mark.parametrize("name", ["thesis.tex", "results.jsonl"])
def test_a_folder_of_other_files_is_refused_even_with_fresh(tmp_path: Path, name: str, raises: Raises) -> None:
    (tmp_path / name).write_text("the user's\n")
    with raises(UsageError, "not-a-sweep", directory=str(tmp_path)), Results(SWEEP, tmp_path, deletes_old_results=True):
        pass
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [(name, "the user's\n")]


@pytest.mark.parametrize("deletes_old_results", [False, True])
def test_a_sweep_that_was_killed_during_its_first_file_begins_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, deletes_old_results: bool
) -> None:
    with monkeypatch.context() as killing:
        killing.setattr(Path, "replace", Mock(side_effect=SystemExit))
        killing.setattr(Path, "unlink", lambda *_, **__: None)
        with pytest.raises(SystemExit), Results(SWEEP, tmp_path):
            pass
    assert len(list(tmp_path.iterdir())) == 2
    assert not (tmp_path / "sweep.json").exists()
    with Results(SWEEP, tmp_path, deletes_old_results=deletes_old_results) as again:
        assert len(again.missing()) == 3
    assert {file.name for file in tmp_path.iterdir()} == {"sweep.json", "results.jsonl"}


def test_a_run_is_on_the_disk_before_the_next_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[int] = []
    with Results(SWEEP, tmp_path) as results:
        monkeypatch.setattr(os, "fsync", lambda file: synced.append(os.fstat(file).st_size))
        for seed in (1, 2):
            results.add(_make_output(seed))
            assert synced[-1] == (tmp_path / "results.jsonl").stat().st_size
    assert len(synced) == 2


def test_two_sweeps_cannot_enter_one_folder(tmp_path: Path, raises: Raises) -> None:
    with (
        Results(SWEEP, tmp_path),
        raises(UsageError, "sweep-locked", directory=str(tmp_path)),
        Results(SWEEP, tmp_path),
    ):
        pass
    with Results(SWEEP, tmp_path):
        pass


def test_reading_results_keeps_their_date(tmp_path: Path) -> None:
    file = _write_results(tmp_path, 1)
    os.utime(file, ns=(0, LONG_AGO_NS))
    with Results(SWEEP, tmp_path) as again:
        list(again.records())
    assert file.stat().st_mtime_ns == LONG_AGO_NS
    assert again.date.timestamp() == LONG_AGO_NS / 1e9


def test_the_name_of_the_folder_depends_on_the_fingerprint(app_file: AppFile, tmp_path: Path) -> None:
    app = app_file()
    names = {Results(make_sweep(app)).directory}
    (tmp_path / "app" / "helper.py").write_text("SPEED = 1\n")
    names.add(Results(make_sweep(app)).directory)
    (tmp_path / "app" / "helper.py").write_text("SPEED = 2\n")
    names.add(Results(make_sweep(app)).directory)
    names.add(Results(make_sweep(app, worlds=("arena",))).directory)
    assert len(names) == 4
    assert all(name.parent == Path("sweeps") and name.name.startswith("odd-") for name in names)
    assert Results(make_sweep(app, seeds=3)).directory in names


def test_results_of_other_seeds_stay_and_the_tables_have_the_seeds_of_the_last_sweep(tmp_path: Path) -> None:
    _write_results(tmp_path, 2, 1, 3, with_tables=True)
    assert _read_seeds_of_table(tmp_path) == ["2", "1", "3"]
    for seeds, done, missing in ((5, [2, 1, 3], [4, 5]), (2, [2, 1], []), (3, [2, 1, 3], [])):
        assert _list_seeds(tmp_path, make_sweep("green-search", seeds)) == (done, missing)
        assert not (tmp_path / "results.csv").exists()
        with Results(make_sweep("green-search", seeds), tmp_path) as results:
            results.write_tables()
        assert _read_seeds_of_table(tmp_path) == list(map(str, done))


def test_a_run_of_another_sweep_is_ignored(tmp_path: Path) -> None:
    file = _write_results(tmp_path, 1, 2)
    for other in (make_record(seed=2, world="moon"), make_record(seed=99), make_record(seed=99)):
        with file.open("a") as lines:
            lines.write(other.to_json() + "\n")
    assert _list_seeds(tmp_path) == ([1, 2], [3])


def test_the_users_world_has_the_name_in_its_file(tmp_path: Path) -> None:
    world = tmp_path / "lab.toml"
    world.write_text('name = "mine"\n[floor]\nlength_m = 6.0\nwidth_m = 6.0\n')
    sweep = make_sweep("green-search", worlds=(str(world),))
    with Results(sweep, tmp_path / "out") as results:
        results.add(RunOutput(make_record(seed=2, world="mine")))
    assert _list_seeds(tmp_path / "out", sweep) == ([2], [1])


@pytest.mark.parametrize("line, kind", [(b"damaged\n", "bad-record"), (None, "duplicate-run")])
def test_a_damaged_or_second_line_is_refused_and_without_it_only_its_run_is_missing(
    tmp_path: Path, line: bytes | None, kind: str, raises: Raises
) -> None:
    file = _write_results(tmp_path, 1, 2, 3)
    first, second, _ = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(first + second + (line or first))
    with raises(UsageError, kind, where=f"{file}, line 3"):
        _list_seeds(tmp_path)
    file.write_bytes(first + second)
    assert _list_seeds(tmp_path)[1] == [3]


def test_a_folder_that_cannot_be_made_is_reported(tmp_path: Path, raises: Raises) -> None:
    (tmp_path / "file").touch()
    for name in ("file/sweep", "file"):
        with raises(UsageError, "unusable-folder", directory=f"{tmp_path}/{name}"):
            Results(SWEEP, tmp_path / name).__enter__()


@pytest.mark.parametrize("deletes_old_results", [False, True])
def test_a_disk_that_fills_during_the_sweep_is_reported_and_leaves_whole_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, deletes_old_results: bool, raises: Raises
) -> None:
    file = tmp_path / "results.jsonl"
    with Results(SWEEP, tmp_path, deletes_old_results=deletes_old_results) as results:
        results.add(ENDED)
        whole = file.read_bytes()
        assert results._journal
        file_object = results._journal._file
        disk = Mock(wraps=file_object)
        no_space = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        disk.write.side_effect = lambda content: (
            disk.write.configure_mock(side_effect=no_space) or file_object.write(content[:10])
        )
        monkeypatch.setattr(results._journal, "_file", disk)
        with raises(UsageError, "results-not-written", file=str(tmp_path), resume_hint=results.resume_hint):
            results.add(ENDED)
    assert file.read_bytes() == whole


def test_a_file_that_cannot_be_replaced_is_reported_and_leaves_no_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    def raise_permission_error(source: Path, target: Path) -> None:
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM), str(target))

    picture = "failures/kinematic-open-1.png"
    with Results(SWEEP, tmp_path) as results:
        results.add(ENDED)
        monkeypatch.setattr(Path, "replace", raise_permission_error)
        with raises(UsageError, "results-not-written", file=str(tmp_path / "results.csv")):
            results.write_tables()
        with raises(UsageError, "results-not-written", file=str(tmp_path / picture)):
            results.add(_make_output(1, Outcome.TIMEOUT, b"png"))
    assert {file.name for file in tmp_path.rglob("*.*")} == {"sweep.json", "results.jsonl"}


def test_parts_of_killed_writes_are_deleted_from_both_folders(tmp_path: Path) -> None:
    _write_results(tmp_path, 1)
    parts = [tmp_path / f".{'a' * 16}.csv", tmp_path / "failures" / f".{'b' * 16}.png"]
    picture = parts[1].with_name("kinematic-open-1.png")
    picture.parent.mkdir()
    for file in (*parts, picture):
        file.touch()
    _write_results(tmp_path)
    assert [file.exists() for file in (*parts, picture)] == [False, False, True]
