from __future__ import annotations

import csv
from pathlib import Path

import pytest

from robotcore.errors import UsageError
from robotcore.sweep import Results, Sweep
from robotcore.sweep.worker import Ended
from tests.robotcore.sweep.conftest import record_of, sweep_of

SWEEP = sweep_of("green-search", seeds=3)


def _kept(directory: Path, *seeds: int) -> Path:
    with Results(SWEEP, directory) as results:
        for seed in seeds:
            results.add(Ended(record_of(seed=seed)))
        results.write_tables()
    return directory / "results.jsonl"


def _seeds(directory: Path, sweep: Sweep = SWEEP) -> tuple[list[int | None], list[int | None]]:
    """Return which seeds are there and which are missing."""
    with Results(sweep, directory) as results:
        return [each.result.seed for each in results.records()], [each.seed for each in results.missing()]


def _rows(directory: Path) -> list[str]:
    with (directory / "results.csv").open(newline="") as table:
        return [row["seed"] for row in csv.DictReader(table)]


def test_more_seeds_go_on_from_what_is_there_and_fewer_show_at_once(tmp_path: Path) -> None:
    _kept(tmp_path, 2, 1, 3)
    assert _seeds(tmp_path, sweep_of("green-search", seeds=5)) == ([2, 1, 3], [4, 5])
    assert _seeds(tmp_path, sweep_of("green-search", seeds=2)) == ([2, 1], [])
    assert _seeds(tmp_path) == ([2, 1, 3], [])


def test_the_tables_are_of_what_was_asked_for_last(tmp_path: Path) -> None:
    _kept(tmp_path, 2, 1, 3)
    assert _rows(tmp_path) == ["2", "1", "3"]
    for seeds in (2, 3):
        with Results(sweep_of("green-search", seeds), tmp_path) as results:
            assert not (tmp_path / "results.csv").exists()
            results.write_tables()
        assert len(_rows(tmp_path)) == seeds


def test_a_run_that_was_not_asked_for_is_left_alone(tmp_path: Path) -> None:
    file = _kept(tmp_path, 1, 2)
    for other in (record_of(seed=2, world="moon"), record_of(seed=99), record_of(seed=99)):
        with file.open("a") as lines:
            lines.write(other.to_json() + "\n")
    assert _seeds(tmp_path) == ([1, 2], [3])


def test_a_world_of_ones_own_goes_by_the_name_in_its_file(tmp_path: Path) -> None:
    world = tmp_path / "lab.toml"
    world.write_text('name = "mine"\n[floor]\nlength_m = 6.0\nwidth_m = 6.0\n')
    sweep = sweep_of("green-search", worlds=(str(world),))
    with Results(sweep, tmp_path / "out") as results:
        results.add(Ended(record_of(seed=2, world="mine")))
    assert _seeds(tmp_path / "out", sweep) == ([2], [1])


def test_a_run_that_is_there_twice_is_told_by_its_line(tmp_path: Path) -> None:
    file = _kept(tmp_path, 1, 2)
    lines = file.read_text().splitlines(keepends=True)
    file.write_text("".join([*lines, lines[0]]))
    words = f"^{file}, line 3: the run kinematic, open, seed 1 is there already. Delete one of its lines$"
    with pytest.raises(UsageError, match=words):
        _seeds(tmp_path)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_spoilt_line_is_told_with_its_number_and_without_it_its_run_alone_is_missing(
    tmp_path: Path, number: int
) -> None:
    file = _kept(tmp_path, 1, 2, 3)
    lines = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(b"".join([*lines[: number - 1], b"spoilt\n", *lines[number:]]))
    words = rf"^{file}, line {number}: no record of a run: .+\. Delete this line, and that run alone is run again$"
    with pytest.raises(UsageError, match=words):
        _seeds(tmp_path)
    file.write_bytes(b"".join([*lines[: number - 1], *lines[number:]]))
    assert _seeds(tmp_path)[1] == [number]


def test_records_come_one_by_one(tmp_path: Path) -> None:
    file = _kept(tmp_path, 1, 2)
    with file.open("a") as lines:
        lines.write("spoilt\n")
    with Results(SWEEP, tmp_path) as results:
        records = results.records()
        assert [next(records).result.seed for _ in range(2)] == [1, 2]
