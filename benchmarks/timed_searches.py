"""Runs searches for `benchmarks.search_speed`, and measures them. It uses the code of the first checkout in the path.

The first line of stdout is a JSON array with the file of the package `robotcore`. Each line of stdin is a JSON object,
and the reply is a JSON array of numbers on a line of stdout.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter, process_time

import cv2

import robotcore
from robotcore import RunRequest, run
from robotcore.sweep import LocalEngine, Sweep, run_sweep

APP, BACKEND = "green-search", "kinematic"


def measure_run(world: str, seed: int) -> tuple[float]:
    """Return the simulated seconds of a run for each second of CPU time, with its start; 0 for a run that failed."""
    start = process_time()
    result = run(RunRequest(APP, BACKEND, world=world, seed=seed))
    return (result.sim_time_s / (process_time() - start) if result.verified else 0.0,)


def measure_sweep(worlds: Sequence[str], seeds: Sequence[int], jobs: int) -> tuple[float, float]:
    """Return the number of successful runs in a minute of a whole sweep, and in a minute of its CPU time."""
    sweep = Sweep(RunRequest(APP), (BACKEND,), tuple(worlds), tuple(seeds))
    start, start_cpu = perf_counter(), _read_cpu_time()
    with tempfile.TemporaryDirectory() as folder:
        results = run_sweep(sweep, LocalEngine(jobs), Path(folder))
        successes = sum(record.result.verified is True for record in results.records())
    return 60 * successes / (perf_counter() - start), 60 * successes / (_read_cpu_time() - start_cpu)


def _read_cpu_time() -> float:
    """Return the CPU time of this process and of its children that have ended, in seconds."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def main() -> None:
    """Reply to each request, until stdin ends."""
    replies, sys.stdout = sys.stdout, sys.stderr  # a sweep may print
    print(json.dumps([robotcore.__file__]), file=replies, flush=True)
    cv2.setNumThreads(1)
    run(RunRequest(APP, BACKEND, timeout_s=1.0))  # imports libraries
    for line in sys.stdin:
        request = json.loads(line)
        measure = measure_sweep if "jobs" in request else measure_run
        print(json.dumps(measure(**request)), file=replies, flush=True)


if __name__ == "__main__":
    main()
