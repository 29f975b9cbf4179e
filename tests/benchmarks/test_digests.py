"""Equal digests of two identical runs, and detection of different and missing ones."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.benchmarks.test_smallest_sizes import run_benchmark

ONLY = ("--only", "run mark-green --robot lookout --backend mock")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    ran = run_benchmark("benchmarks.digests", "record", str(tmp_path), *ONLY)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return tmp_path


def compare(folder: Path) -> tuple[int, list[str]]:
    """Return the exit status of a comparison, and its counts of runs and replays."""
    ran = run_benchmark("benchmarks.digests", "compare", str(folder))
    return ran.returncode, [line for line in ran.stdout.splitlines() if line.startswith("| mock")]


@pytest.mark.slow
def test_the_same_code_gives_equal_digests_and_replays(folder: Path) -> None:
    assert compare(folder) == (0, ["| mock | 1 | 0 | 0 |", "| mock, replayed | 1 | 0 | 0 |"])


@pytest.mark.slow
@pytest.mark.parametrize("field", ["exit_status", "outcome", "/eye", "/ticks"])
def test_a_changed_value_is_found(folder: Path, field: str) -> None:
    file = folder / "digests.json"
    digests: dict[str, dict[str, Any]] = json.loads(file.read_text())
    for digest in digests.values():
        digest[field] = "another"
    file.write_text(json.dumps(digests))
    assert compare(folder) == (1, ["| mock | 0 | 1 | 0 |", "| mock, replayed | 1 | 0 | 0 |"])


@pytest.mark.slow
def test_a_run_without_results_and_a_lost_recording_are_missing(folder: Path) -> None:
    file = folder / "digests.json"
    file.write_text(file.read_text().replace("mark-green", "mark-gone"))
    assert compare(folder) == (1, ["| mock | 0 | 0 | 1 |", "| mock, replayed | 0 | 0 | 1 |"])


@pytest.mark.slow
def test_a_recording_that_is_cut_differs(folder: Path) -> None:
    (recording,) = (folder / "recordings").iterdir()
    recording.write_bytes(recording.read_bytes()[:20_000])
    assert compare(folder) == (1, ["| mock | 1 | 0 | 0 |", "| mock, replayed | 0 | 1 | 0 |"])


@pytest.mark.slow
def test_digests_are_not_overwritten(folder: Path) -> None:
    assert run_benchmark("benchmarks.digests", "record", str(folder), *ONLY).returncode == 2
