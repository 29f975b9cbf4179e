"""Measure how fast searches run in the kinematic simulator, alone and in a sweep, also against another checkout.

    python -m benchmarks.search_speed --against ../robotcore-before --sweep-seeds 1-200

The speed of a run alone is its simulated time for each second of CPU time, with its start. Only libraries are imported
before. A sweep is timed from the check to the tables, with the start of its two processes: by the wall clock, and by
the CPU time of all its processes. With ``--against``, a process with the code of another checkout does the same. Both
take turns, so that other load on the machine affects both. A run that fails counts for no speed. The exit status is 1
if a bound is broken.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import product
from pathlib import Path
from typing import Any, NoReturn

from benchmarks.report import Interval, compute_median, parse_options, print_table
from robotcore.sweep.spec import parse_seeds

ROOT = Path(__file__).parents[1]
PROGRAM = ROOT / "benchmarks" / "timed_searches.py"
JOBS = 2
MIN_SPEED, MIN_SUCCESS = 25.0, 0.9
"""The least number of simulated seconds in a second of CPU time, and the least share of successful runs."""

Row = tuple[str, str, str, str]


class Worker:
    """A process that measures searches with the code of one checkout."""

    def __init__(self, process: subprocess.Popen[str], checkout: Path) -> None:
        self._process, self._checkout = process, checkout
        (package,) = self._read()
        if checkout not in Path(package).parents:
            sys.exit(f"{checkout} has no package robotcore. Name a checkout of it with --against")

    def measure(self, request: dict[str, Any]) -> list[float]:
        """Return the speeds of a run or of a sweep."""
        assert self._process.stdin
        try:
            self._process.stdin.write(json.dumps(request) + "\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            self._exit()
        return self._read()

    def _read(self) -> list[Any]:
        assert self._process.stdout
        if not (line := self._process.stdout.readline()):
            self._exit()
        reply: list[Any] = json.loads(line)
        return reply

    def _exit(self) -> NoReturn:
        sys.exit(f"the process with the code of {self._checkout} has failed. See its output above")


def main() -> int:
    """Measure runs and sweeps, and print their speeds."""
    options = parse_options(
        __doc__, worlds="arena,clutter,occluded", seeds="1-10", sweeps=3, against="", **{"sweep-seeds": "1-10"}
    )
    worlds = options.worlds.split(",")
    runs = [{"world": world, "seed": seed} for world, seed in product(worlds, parse_seeds(options.seeds))]
    sweep = {"worlds": worlds, "seeds": parse_seeds(options.sweep_seeds), "jobs": JOBS}
    sweep_runs = len(worlds) * len(sweep["seeds"])
    with ExitStack() as started:
        checkouts = [ROOT, *([Path(options.against).resolve()] if options.against else [])]
        workers = [started.enter_context(start_worker(checkout)) for checkout in checkouts]
        speeds = select(measure_in_turn(workers, runs), 0)
        measured = measure_in_turn(workers, [sweep] * options.sweeps)
    rates, cpu_rates = select(measured, 0), select(measured, 1)
    speed, in_sweeps = compute_median(speeds[0]), f"{options.sweeps} sweeps of {sweep_runs} runs"
    success = sum(speed > 0 for speed in speeds[0]) / len(runs)
    rows = [
        ("successful runs", f"{success:.0%}", "", f"at least {MIN_SUCCESS:.0%}"),
        build_row(f"simulated seconds in a CPU second, {len(runs)} runs", speed, ".1f", f"at least {MIN_SPEED:g}"),
        build_row(f"runs a minute on {JOBS} processes, {in_sweeps}", compute_median(rates[0]), ".0f"),
        build_row("runs in a minute of their CPU time", compute_median(cpu_rates[0]), ".0f"),
    ]
    if options.against:
        rows.append(build_row("simulated seconds in a CPU second ÷ the other checkout's", compute_ratio(speeds), ".2f"))
        rows.append(build_row("runs a minute ÷ the other checkout's", compute_ratio(rates), ".2f"))
        rows.append(build_row("runs in a minute of CPU time ÷ the other checkout's", compute_ratio(cpu_rates), ".2f"))
    print_table(("green-search in the kinematic simulator", "median", "95 % interval", "bound"), rows)
    return int(speed.median < MIN_SPEED or success < MIN_SUCCESS)


@contextmanager
def start_worker(checkout: Path) -> Iterator[Worker]:
    """Start a process with the code of a checkout, and end it after use."""
    environment = {**os.environ, "PYTHONPATH": str(checkout)}
    command = [sys.executable, str(PROGRAM)]
    with subprocess.Popen(  # noqa: S603  this Python
        command, env=environment, cwd=checkout, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        yield Worker(process, checkout)


def measure_in_turn(workers: list[Worker], requests: Iterable[dict[str, Any]]) -> list[list[list[float]]]:
    """Return the replies of each worker. The order of the workers alternates."""
    measured: list[list[list[float]]] = [[] for _ in workers]
    for number, request in enumerate(requests):
        order = range(len(workers))
        for index in reversed(order) if number % 2 else order:
            measured[index].append(workers[index].measure(request))
    return measured


def select(measured: list[list[list[float]]], index: int) -> list[list[float]]:
    """Return one number of all replies of each worker."""
    return [[reply[index] for reply in replies] for replies in measured]


def compute_ratio(speeds: list[list[float]]) -> Interval:
    """Return the median of the ratios of the pairs of successful runs."""
    return compute_median(speed / other for speed, other in zip(*speeds, strict=True) if speed and other)


def build_row(claim: str, value: Interval, form: str, bound: str = "–") -> Row:
    """Return a row of the table."""
    return (claim, *value.format_cells(form), bound)


if __name__ == "__main__":
    sys.exit(main())
