"""Runs searches for `benchmarks.search_speed`, and measures them. It uses the code of the first checkout in the path.

Each line of stdin is a JSON object, and the reply is a number on a line of stdout.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter, process_time

import cv2

from robotcore import RunRequest, run
from robotcore.sweep import LocalEngine, Sweep, run_sweep

APP, BACKEND = "green-search", "kinematic"


def measure_run(world: str, seed: int) -> float:
    """Return the simulated seconds of a run for each second of CPU time, with its start."""
    start = process_time()
    result = run(RunRequest(APP, BACKEND, world=world, seed=seed))
    return result.sim_time_s / (process_time() - start)


def measure_sweep(worlds: Sequence[str], seeds: Sequence[int], jobs: int) -> float:
    """Return the number of runs a minute in a whole sweep, from the check to the tables."""
    sweep = Sweep(RunRequest(APP), (BACKEND,), tuple(worlds), tuple(seeds))
    start = perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        run_sweep(sweep, LocalEngine(jobs), Path(folder))
    return 60 * len(sweep) / (perf_counter() - start)


def main() -> None:
    """Reply to each request, until stdin ends."""
    replies, sys.stdout = sys.stdout, sys.stderr  # a sweep may print
    cv2.setNumThreads(1)
    run(RunRequest(APP, BACKEND, timeout_s=1.0))  # imports libraries
    for line in sys.stdin:
        request = json.loads(line)
        measure = measure_sweep if "jobs" in request else measure_run
        print(measure(**request), file=replies, flush=True)


if __name__ == "__main__":
    main()
