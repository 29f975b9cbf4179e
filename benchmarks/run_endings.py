"""Check that every ending of a run stops the motors, and measure how soon.

    python -m benchmarks.run_endings --trials 200 --exhausted 100 --simulators 50

Each trial is a process: the command line runs an app on a robot in real time, whose motors log each command with its
time. At a random moment while the robot drives, the process gets a signal, the app raises or hangs, or the camera
fails. A hanging app waits, computes, or catches every exception. The time is from the event to the stop of the last
motor. For a hang, the event is the last return of the app.

Then apps use up the threads or the memory of their process first, with a guardian or without. If such an app continues,
the time is from the last command. Then half of the simulators in processes of their own are killed during a run, and
half are suspended. The exit status is 1 if a motor was not stopped, or a bound is broken.
"""

from __future__ import annotations

import argparse
import json
import signal
import statistics
import sys
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import TypeVar

from benchmarks.report import at_least_one, machine, print_table
from benchmarks.run_endings_parts.trials import (
    TrialResult,
    register,
    run_exhausted,
    run_failing,
    run_orphaned,
    run_signalled,
)

HANG_BOUND_S, NAMED_BOUND_S = 0.150, 2.0

ResultT = TypeVar("ResultT")
Trial = Callable[..., TrialResult]

KINDS: dict[str, tuple[Trial, int]] = {
    "interrupted (SIGINT)": (partial(run_signalled, number=signal.SIGINT), -signal.SIGINT),
    "terminated (SIGTERM)": (partial(run_signalled, number=signal.SIGTERM), -signal.SIGTERM),
    "hung up (SIGHUP)": (partial(run_signalled, number=signal.SIGHUP), -signal.SIGHUP),
    "raises": (partial(run_failing, ending="raise"), 5),
    "hangs": (partial(run_failing, ending="hangs"), 4),
    "loses its camera": (partial(run_failing, ending="loses its camera"), 3),
}
"""The endings, and the exit status of each, as `subprocess` returns it."""

EXHAUSTION_KINDS: Mapping[str, tuple[Trial, int]] = {
    f"uses up its {what}, {then}": (partial(run_exhausted, ending=ending, leaks=what), status)
    for what in ("threads", "memory")
    for then, ending, status in (("hangs", "hangs", 4), ("raises", "raise", 5))
} | {"uses up its threads, goes on": (partial(run_exhausted, ending="continue", leaks="threads"), 0)}
"""The endings of apps that first use up threads or memory. Such a run also has to print one line of JSON."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=at_least_one, default=200)
    parser.add_argument("--exhausted", type=at_least_one, default=100)
    parser.add_argument("--simulators", type=at_least_one, default=50)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    random = Random(options.seed)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # under nohup, no trial could be hung up
    print(machine())
    is_good = _print_endings(KINDS, options.trials, random)
    print()
    is_good = _print_endings(EXHAUSTION_KINDS, options.exhausted, random) and is_good
    print()
    return int(not (_print_simulators(options.simulators, random) and is_good))


def _print_endings(kinds: Mapping[str, tuple[Trial, int]], trials: int, random: Random) -> bool:
    ended: dict[str, list[TrialResult]] = {kind: [] for kind in kinds}
    for index in range(trials):
        kind = list(kinds)[index % len(kinds)]
        ended[kind].append(_in_a_directory(partial(kinds[kind][0], random=random)))
    print_table(
        ("ending", "every motor stopped", "expected exit status", "ms to the last stop: median", "worst"),
        [(kind, *_summarize(results, kinds[kind][1])) for kind, results in ended.items() if results],
    )
    results = [result for each in ended.values() for result in each]
    print(f"\n{sum(result.is_stopped for result in results)} of {trials} runs stopped every motor")
    hangs = [result.delay_s for kind, each in ended.items() if kind.endswith("hangs") for result in each]
    is_as_said = all(result.status == kinds[kind][1] for kind, each in ended.items() for result in each)
    return all(result.is_stopped for result in results) and is_as_said and max(hangs, default=0.0) <= HANG_BOUND_S


def _summarize(results: list[TrialResult], status: int) -> tuple[str, ...]:
    delays = [result.delay_s * 1e3 for result in results]
    stopped, as_said = sum(r.is_stopped for r in results), sum(r.status == status for r in results)
    count = len(results)
    return f"{stopped}/{count}", f"{as_said}/{count}", f"{statistics.median(delays):.0f}", f"{max(delays):.0f}"


def _print_simulators(count: int, random: Random) -> bool:
    rows, is_good = [], True
    failures = (("killed", signal.SIGKILL, count - count // 2), ("suspended", signal.SIGSTOP, count // 2))
    for what, number, trials in failures[:count]:
        ended = [_in_a_directory(partial(run_orphaned, random=random, number=number)) for _ in range(trials)]
        delays = [delay for _, delay, _ in ended]
        named = sum(status == 3 and delay <= NAMED_BOUND_S and _is_named(output) for status, delay, output in ended)
        hung = sum(status is None for status, _, _ in ended)
        middle, worst = f"{statistics.median(delays):.2f}", f"{max(delays):.2f}"
        rows.append((what, f"{named}/{len(ended)}", str(hung), middle, worst))
        is_good = is_good and named == len(ended)
    columns = ("simulator", f"named error within {NAMED_BOUND_S:g} s", "hangs", "s to the end: median", "worst")
    print_table(columns, rows)
    return is_good


def _is_named(output: str) -> bool:
    reports = json.loads(output) if output else {}
    return any(name in reports.get("reason", "") for name in ("_motor", "_encoder", "nose", "eye", "backend"))


def _in_a_directory(trial: Callable[[Path], ResultT]) -> ResultT:
    with TemporaryDirectory() as directory:
        register(Path(directory))
        return trial(Path(directory))


if __name__ == "__main__":
    sys.exit(main())
