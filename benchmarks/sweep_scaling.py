"""Measure what a sweep costs beside its runs, and how much faster two processes are than one.

    python -m benchmarks.sweep_scaling

Whole sweeps are timed, from the check to the tables, with the start of the processes. Only the first ten seconds of
each run count, so that no run is much longer than the others. The overhead is measured with shorter runs. They are
compared with the same runs by `robotcore.run`, one after another in one warm process. All take turns. The machine needs
two idle cores. The exit status is 1 if a bound is broken.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import cv2

from benchmarks.report import measure_ratio, parse_options, print_table
from robotcore import RunRequest, run
from robotcore.sweep import LocalEngine, Sweep, run_sweep
from robotcore.sweep.spec import parse_seeds

MIN_SPEED_UP, MAX_OVERHEAD = 1.8, 3.0


def main() -> int:
    """Measure the pairs of sweeps, and print the ratios."""
    options = parse_options(__doc__, seeds="1-40", runs=100, timeout=10.0, pairs=30)
    request = RunRequest("green-search", timeout_s=options.timeout)
    sweep = Sweep(request, ("kinematic",), ("clutter",), parse_seeds(options.seeds))
    cv2.setNumThreads(1)
    speed_up = measure_ratio(lambda: _time_sweep(sweep, 1), lambda: _time_sweep(sweep, 2), options.pairs)
    short = RunRequest("avoid-obstacles", settings={"duration_s": 2.0})
    shorts = Sweep(short, sweep.backends, sweep.worlds, tuple(range(options.runs)))
    _time_runs(shorts)
    alone = list[float]()
    overhead = measure_ratio(lambda: _time_sweep(shorts, 1), lambda: _append(_time_runs(shorts), alone), options.pairs)
    run_ms = 1000 * statistics.median(alone) / len(shorts)
    short_runs = f"{len(shorts)} short runs in a sweep ÷ alone, {run_ms:.0f} ms each"
    rows = [
        (f"speed-up of two processes, {len(sweep)} runs", *speed_up.format_cells(".2f"), f"at least {MIN_SPEED_UP:g}"),
        (short_runs, *overhead.format_cells(".2f"), f"at most {MAX_OVERHEAD:g}"),
    ]
    print_table((f"{options.pairs} pairs", "median", "95 % interval", "bound"), rows)
    return int(speed_up.median < MIN_SPEED_UP or overhead.median > MAX_OVERHEAD)


def _append(seconds: float, noted: list[float]) -> float:
    noted.append(seconds)
    return seconds


def _time_sweep(sweep: Sweep, jobs: int) -> float:
    start = perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        run_sweep(sweep, LocalEngine(jobs), Path(folder))
    return perf_counter() - start


def _time_runs(sweep: Sweep) -> float:
    start = perf_counter()
    for request in sweep.requests():
        run(request)
    return perf_counter() - start


if __name__ == "__main__":
    sys.exit(main())
