"""Check that an app whose simulator dies ends soon with a named error, and that the next run works.

    python -m benchmarks.remote_deaths --trials 50

Each trial runs the command line in its own process, in a double of CoppeliaSim, over either remote API. The app drives
in real time or at full speed. At a random moment the double is killed (SIGKILL), hangs (SIGSTOP), or is killed and
started again at once. The time is from there to the end of the process. Then the same command runs again on the same
port, in a new double, or in the one that hung and continues. The exit status is 1 if a bound is broken.
"""

from __future__ import annotations

import argparse
import json
import re
import statistics
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from random import Random
from subprocess import DEVNULL, PIPE, Popen, TimeoutExpired
from time import monotonic, sleep
from typing import NamedTuple

from benchmarks.remote.doubles import ROOT, DoubleProcess
from benchmarks.remote.driving import BEGUN
from benchmarks.report import at_least_one, machine, print_table

NAMED_BOUND_S, HANG_S = 2.0, 20.0
MOMENTS_S = 1.5
"""The longest time between the first ticks of a run and the end of its double, in seconds."""

FAILED = 3
"""The exit status of a run whose backend or device has failed."""

APP = Path(__file__).parent / "remote" / "driving.py"


class Way(NamedTuple):
    """A function that ends or suspends a double, and the function that restores it."""

    strike: Callable[[DoubleProcess], None]
    restore: Callable[[DoubleProcess], None]


class TrialResult(NamedTuple):
    """The result of a trial: exit status (None if the run hung), delay, output, and the problem of the next run."""

    status: int | None
    delay_s: float
    output: str
    reason: str
    next_fault: str

    @property
    def is_named(self) -> bool:
        return (
            self.status == FAILED
            and self.delay_s <= NAMED_BOUND_S
            and "Traceback" not in self.output
            and self.reason != ""
        )


def main() -> int:
    """Execute the trials, and print the results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=at_least_one, default=50, help="over each API")
    parser.add_argument("--apis", default="coppeliasim,vrep")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(machine(), flush=True)
    ended = {api: _run_trials(api, options.trials, Random(options.seed)) for api in options.apis.split(",")}
    columns = (
        "server",
        f"named within {NAMED_BOUND_S:g} s",
        "hangs",
        "s to the end: median",
        "slowest",
        "next run works",
    )
    print_table(
        columns,
        [_build_row(f"{api}, {way}", each) for api, ways in ended.items() for way, each in ways.items() if each],
    )
    results = [result for ways in ended.values() for each in ways.values() for result in each]
    for lines in sorted({_simplify_reason(result.reason) for result in results}):
        print(f"reason: {lines}")
    return int(not all(result.is_named and not result.next_fault for result in results))


def _run_trials(api: str, trials: int, random: Random) -> dict[str, list[TrialResult]]:
    ended: dict[str, list[TrialResult]] = {name: [] for name in WAYS}
    with DoubleProcess("rover" if api == "vrep" else None, seed=1) as double:
        for index in range(trials):
            name = list(WAYS)[index % len(WAYS)]
            ended[name].append(result := _run_trial(api, double, WAYS[name], random))
            if not result.is_named or result.next_fault:
                print(f"failing: {api}, {name}, trial {index}: {result}", flush=True)
    return ended


def _run_trial(api: str, double: DoubleProcess, way: Way, random: Random) -> TrialResult:
    with _start_run(api, double, 60.0, is_paced=random.random() < 0.5) as process:
        assert process.stderr
        lines = process.stderr.readline()
        sleep(random.uniform(0.0, MOMENTS_S))
        if lines.strip() != BEGUN or process.poll() is not None:
            return TrialResult(process.poll(), 0.0, lines + process.communicate()[1], "", "not tried")
        event = monotonic()
        way.strike(double)
        status = _await_status(process)
        delay = monotonic() - event
        answer, output = process.communicate()
    way.restore(double)
    return TrialResult(status, delay, output, _read_reason(answer), _find_next_fault(api, double))


def _start_run(api: str, double: DoubleProcess, duration_s: float, *, is_paced: bool) -> Popen[str]:
    port = double.legacy_port if api == "vrep" else double.zmq_port
    where = ["--backend", api, "--port", str(port), "--world", "arena", "--seed", "1"]
    pace = ["--realtime"] if is_paced else []
    run = [sys.executable, "-m", "robotcore", "run", str(APP), "--set", f"duration_s={duration_s}", "--json"]
    return Popen([*run, *where, *pace], stdin=DEVNULL, stdout=PIPE, stderr=PIPE, text=True, cwd=ROOT)  # noqa: S603  our own


def _find_next_fault(api: str, double: DoubleProcess) -> str:
    """Execute the run again. Return its problem; an empty text if it succeeded."""
    with _start_run(api, double, 0.5, is_paced=False) as process:
        status = _await_status(process)
        answer, output = process.communicate()
    return "" if status == 0 else f"{status}: {_read_reason(answer) or output}"


def _await_status(process: Popen[str]) -> int | None:
    try:
        return process.wait(HANG_S)
    except TimeoutExpired:
        process.kill()
        return None


def _read_reason(answer: str) -> str:
    with suppress(ValueError):
        return str(json.loads(answer)["reason"])
    return ""


def _simplify_reason(reason: str) -> str:
    """Return a reason without names of calls, ports and secondary errors, so that equal reasons can be counted."""
    line = reason.partition("; closing ")[0].partition("\n")[0]
    return re.sub(r"sim\.\w+", "sim.…", re.sub(r":\d{4,5}\b", ":…", line))


def _build_row(name: str, ended: list[TrialResult]) -> tuple[str, ...]:
    delays = [each.delay_s for each in ended]
    return (
        name,
        f"{sum(each.is_named for each in ended)}/{len(ended)}",
        str(sum(each.status is None for each in ended)),
        f"{statistics.median(delays):.2f}",
        f"{max(delays):.2f}",
        f"{sum(not each.next_fault for each in ended)}/{len(ended)}",
    )


def _restart(double: DoubleProcess) -> None:
    double.kill()
    double.start()


def _replace(double: DoubleProcess) -> None:
    double.kill()
    double.launch()


WAYS = {
    "killed": Way(DoubleProcess.kill, DoubleProcess.start),
    "hangs, and is restarted": Way(DoubleProcess.suspend, _restart),
    "hangs, and goes on": Way(DoubleProcess.suspend, DoubleProcess.resume),
    "restarted at once": Way(_replace, DoubleProcess.await_serving),
}


if __name__ == "__main__":
    sys.exit(main())
