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

from tests.robotcore.deploy.sshd import require_programs
from tests.robotcore.live.chromium import require_chromium

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "benchmarks"
LIMIT_S = 110
"""The time limit of a benchmark in seconds, less than the limit of a test."""

EXACT = {
    "calibration_drive": "--robots 1",
    "calibration_motors": "--robots 1 --drives 1",
    "drives": "--robots freenove-4wd picar",
    "faults": "--seeds 1 --world open --jobs 1 --fault 'camera drop=0.3'",
    "hand_driven_runs": "--runs 1 --backends kinematic",
    "heading": "--runs 1",
    "hostile_recordings": "--kinds 1 --files 1",
    "hostile_robot": "--kinds 1",
    "lines": "--runs 1",
    "manoeuvres": "--runs 1 --squares 1",
    "foreign_kinds": "--runs 1",
    "painted_agreement": "--poses 1",
    "project_ci": "--here --kinds project --workflows github",
    "replay": "--runs 1 --backends kinematic",
    "servo_sweep": "--sweeps 1",
    "success": "--seeds 1 --worlds open --backends kinematic --twice 1 --jobs 1",
}
"""The options of the benchmarks that meet their bounds at any size."""

BOUNDED = {
    "detector": "--frames 4",
    "fidelity": "--robots 1 --simulators kinematic",
    "flight_recorder": "--hours 0.01 --last 10 --kills 1 --ring 1",
    "fast_odometry": "--runs 2 --seconds 2.0 --backends kinematic --pairs 1 --search 1.0",
    "floor_pictures": "--pairs 1 --ticks 1",
    "guardian": "--trials 1",
    "hostile_clients": "--minutes 0.05 --messages 20",
    "installation": "--repeats 1",
    "interruptions": "--trials 1",
    "jitter": "--rounds 1 --seconds 1.0",
    "live_page": "--backends kinematic --presses 1 --trials 1 --rounds 1 --seconds 2.0",
    "loop": "--pairs 1 --ticks 1 --search 0.5",
    "recording": "--pairs 1 --kills 1 --seconds 0.5 --search 1",
    "run_endings": "--trials 1 --exhausted 1 --simulators 1",
    "search_speed": "--worlds open --seeds 1 --sweeps 1 --sweep-seeds 1 --against .",
    "silent_operator": "--trials 1 --backends kinematic",
    "slip": "--runs 1",
    "startup": "--pairs 1",
    "tick": "--repeats 1 --ticks 50",
}
SIZES = EXACT | BOUNDED


def list_benchmarks() -> list[str]:
    """Return the names of all benchmarks. The tests of a part run those that are not in `SIZES`."""
    return sorted(file.stem for file in FOLDER.glob("*.py") if is_benchmark(file.read_text()))


def is_benchmark(text: str) -> bool:
    """Return whether a file is a benchmark, and not a program that a benchmark starts."""
    return "__main__" in text and "_options(" in text


def run_benchmark(name: str, *options: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", f"benchmarks.{name}", *options]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=LIMIT_S)


@pytest.mark.slow
@pytest.mark.parametrize("name", SIZES)
def test_a_benchmark_runs_at_its_smallest_size(name: str) -> None:
    if name == "hostile_robot":
        require_programs()
    if name == "live_page":
        require_chromium()
    ran = run_benchmark(name, *shlex.split(SIZES[name]))
    assert ran.returncode in ({0} if name in EXACT else {0, 1}), ran.stdout + ran.stderr
    assert "Traceback" not in ran.stderr, ran.stderr
    assert "| --- |" in ran.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in list_benchmarks() if name not in SIZES])
def test_a_benchmark_has_a_help_text(name: str) -> None:
    ran = run_benchmark(name, "--help")
    assert (ran.returncode, ran.stdout.partition(":")[0]) == (0, "usage")
