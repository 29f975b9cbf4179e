"""Measure what a sweep costs beside its runs, and how much faster two processes are than one.

    python -m benchmarks.sweep_scaling

Whole sweeps are timed, from the check to the tables, with the start of the processes. Only the first ten seconds of
each run count, so that no run is much longer than the others. The overhead is measured with shorter runs. They are
compared with the same runs by `robotcore.run`, one after another in one warm process. All take turns. The machine needs
two idle cores. The exit status is 1 if a bound is broken.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import cv2

from benchmarks.pairs import paired_ratios
from benchmarks.report import at_least_one, machine, print_table
from robotcore import RunRequest, run
from robotcore.sweep import LocalEngine, Sweep, run_sweep
from robotcore.sweep.spec import parse_seeds

MIN_SPEED_UP, MAX_OVERHEAD = 1.8, 3.0


def main() -> int:
    """Measure the pairs of sweeps, and print the ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--world", default="clutter")
    parser.add_argument("--seeds", default="1-40")
    parser.add_argument("--runs", type=at_least_one, default=100, help="the number of short runs, for the overhead")
    parser.add_argument("--timeout", type=float, default=10.0)
    parser.add_argument("--pairs", type=at_least_one, default=30)
    options = parser.parse_args()
    request = RunRequest("green-search", timeout_s=options.timeout)
    sweep = Sweep(request, (options.backend,), (options.world,), parse_seeds(options.seeds))
    cv2.setNumThreads(1)
    speed_up = paired_ratios(lambda: _time_sweep(sweep, 1), lambda: _time_sweep(sweep, 2), options.pairs)
    short = RunRequest("avoid-obstacles", settings={"duration_s": 2.0})
    shorts = Sweep(short, (options.backend,), (options.world,), tuple(range(options.runs)))
    _time_runs(shorts)
    alone = list[float]()
    overhead = paired_ratios(lambda: _time_sweep(shorts, 1), lambda: _append(_time_runs(shorts), alone), options.pairs)
    run_ms = 1000 * statistics.median(alone) / len(shorts)
    print(machine())
    print_table(
        (f"{options.pairs} pairs", "median", "95 % interval", "bound"),
        [
            (
                f"speed-up of two processes, {len(sweep)} runs",
                *_format_range(speed_up, "{:.2f}"),
                f"at least {MIN_SPEED_UP:g}",
            ),
            (
                f"{len(shorts)} short runs in a sweep ÷ alone, {run_ms:.0f} ms each",
                *_format_range(overhead, "{:.2f}"),
                f"at most {MAX_OVERHEAD:g}",
            ),
        ],
    )
    return int(speed_up[0] < MIN_SPEED_UP or overhead[0] > MAX_OVERHEAD)


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


def _format_range(measured: tuple[float, float, float], form: str) -> tuple[str, str]:
    median, low, high = (form.format(value) for value in measured)
    return median, f"{low} to {high}"


if __name__ == "__main__":
    sys.exit(main())
