"""Each benchmark runs at its smallest size, prints a table, and raises no exception.

At this size, benchmarks that measure times or few pictures can miss their bounds, so exit status 1 is allowed. The
other benchmarks meet their bounds at any size.
"""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "benchmarks"
LIMIT_S = 110
"""The time limit of a benchmark in seconds, less than the limit of a test."""

STARTED_BY_ANOTHER = {"benchmarks.lock_holding_run"}
EXACT = {
    "echoes": "--cycles 50 --pairs 1",
    "faults": "--seeds 1 --jobs 1 --fault 'camera drop=0.3'",
    "hostile_recordings": "--files 20 --kinds 1 --small",
    "hostile_robot": "--kinds 1",
    "remote_success": "--seeds 1 --backends vrep",
    "replay": "--runs 1 --backends kinematic",
    "serial_commands": "--seconds 0.2",
    "serial_parsers": "--bytes 1000 --seeds 1",
    "success": "--seeds 1 --worlds arena --backends kinematic --twice 1 --jobs 1",
    "virtual_pi": "--seeds 1 --jobs 1",
    "wheels": "--backends kinematic",
}
"""The options of the benchmarks that meet their bounds at any size."""

TIMED = {
    "guardian": "--trials 1",
    "loop": "--backends pybullet --pairs 1 --ticks 1",
    "painted_camera": "--worlds arena --poses 1",
    "pins": "--pairs 1 --calls 20",
    "recording": "--pairs 1 --kills 1",
    "remote_cycle": "--pairs 1 --cycles 1",
    "remote_deaths": "--trials 1 --apis vrep",
    "serial_unplugged": "--trials 1 --board 'our firmware'",
    "startup": "--pairs 1",
    "sweep_scaling": "--pairs 1 --seeds 1-2 --timeout 1 --runs 2",
    "tick": "--repeats 1 --ticks 50",
    "run_endings": "--trials 1 --exhausted 1 --simulators 1",
}
FEW_PICTURES = {"detector": "--frames 4", "eyes.tuning": "--frames 1 --seeds 11"}
SIZES = EXACT | TIMED | FEW_PICTURES
TABLELESS = {"eyes.tuning"}


def list_benchmarks() -> list[str]:
    """Return the names of all benchmarks. Those that are not in `SIZES` need root or a folder."""
    files = (file for file in FOLDER.rglob("*.py") if "__main__" in file.read_text())
    modules = (".".join(file.relative_to(ROOT).with_suffix("").parts) for file in files)
    return sorted(set(modules) - STARTED_BY_ANOTHER)


def run_benchmark(name: str, *options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", name, *options]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=LIMIT_S)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in list_benchmarks() if name.partition(".")[2] in SIZES])
def test_a_benchmark_runs_at_its_smallest_size(name: str) -> None:
    short = name.partition(".")[2]
    ran = run_benchmark(name, *shlex.split(SIZES[short]))
    assert ran.returncode in ({0} if short in EXACT else {0, 1}), ran.stdout + ran.stderr
    assert "Traceback" not in ran.stderr, ran.stderr
    assert short in TABLELESS or "| --- |" in ran.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in list_benchmarks() if name.partition(".")[2] not in SIZES])
def test_a_benchmark_has_a_help_text(name: str) -> None:
    ran = run_benchmark(name, "--help")
    assert (ran.returncode, ran.stdout.partition(":")[0]) == (0, "usage")
