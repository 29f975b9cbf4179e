"""What a recording costs a loop, and what a process that is killed leaves of it.

    python -m benchmarks.recording

A robot with a camera of 320 × 240 at 20 Hz looks for a ball. From the moment that its step begins until the tick is
noted, recorder included, once with a recording and once without: in pairs, in turn, at real time. Then whole searches
as fast as the machine goes. Then processes that record are killed (SIGKILL) at moments that a seed draws: what of the
time until then is in the file. Exit status 1 where a bound is broken.
"""

from __future__ import annotations

import argparse
import random
import signal
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

from benchmarks.pairs import median_with_interval, paired_ratios
from benchmarks.report import machine, print_table
from robotcore.errors import RecordingError
from robotcore.recording import read
from robotcore.recording.recorder import Recorder
from robotcore.session import Run, RunRequest, RunResult, run
from robotcore.trace import TickRecord

WATCHED_S = 4.0
COST_BOUND_MS, LOST_BOUND_S = 0.3, 1.0
KILLED = "tests.robotcore.recording.recording_run"


@dataclass
class Stopwatch:
    """An observer, the last one: how long each tick took, in ms, from one sleep to the next."""

    def begin(self, run: Run) -> None:
        self.ticks: list[float] = []
        step, behaviour = run.behaviour.step, run.behaviour

        def timed(robot: object) -> object:
            self._start = perf_counter()
            return step(robot)  # type: ignore[arg-type]

        behaviour.step = timed  # type: ignore[method-assign, assignment]

    def tick(self, record: TickRecord) -> None:
        self.ticks.append(1e3 * (perf_counter() - self._start))

    def end(self, result: RunResult) -> None: ...


def main() -> int:
    """Measure all three and print them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=12)
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    print(machine())
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap"
        more_ms = _tell_cost(file, asked.pairs)
        lost_s = _tell_kills(file, asked.kills, random.Random(asked.seed))
    return int(more_ms > COST_BOUND_MS or lost_s > LOST_BOUND_S)


def _tell_cost(file: Path, pairs: int) -> float:
    """Print what a recording costs; return how much longer a tick takes, in ms."""
    tick_ms: dict[bool, list[float]] = {True: [], False: []}
    for pair in range(pairs):
        for is_recorded in (True, False) if pair % 2 else (False, True):
            tick_ms[is_recorded].append(statistics.median(_ticks_ms(file if is_recorded else None)))
    more = [recorded - bare for recorded, bare in zip(tick_ms[True], tick_ms[False], strict=True)]
    ratio = paired_ratios(lambda: _search_s(file), lambda: _search_s(None), pairs)
    size = file.stat().st_size
    rows = [
        ("a tick without a recording, ms", *_told(tick_ms[False]), ""),
        ("a tick with one, ms", *_told(tick_ms[True]), ""),
        ("the difference, ms", *_told(more), f"≤ {COST_BOUND_MS:g}"),
        ("a whole simulated search, with ÷ without", f"{ratio[0]:.3f}", f"{ratio[1]:.3f} to {ratio[2]:.3f}", ""),
        ("the file of that search, KB a simulated second", f"{size / 1e3 / _simulated_s(file):.0f}", "", ""),
    ]
    print_table((f"recording, {pairs} pairs", "median", "95 % interval of it", "bound"), rows)
    return statistics.median(more)


def _ticks_ms(file: Path | None) -> list[float]:
    watch = Stopwatch()
    _run(file, RunRequest("green-search", world="clutter", seed=1, timeout_s=WATCHED_S, realtime=True), watch)
    return watch.ticks[5:]


def _search_s(file: Path | None) -> float:
    start = perf_counter()
    _run(file, RunRequest("green-search", world="clutter", seed=1))
    return perf_counter() - start


def _run(file: Path | None, request: RunRequest, *watching: Stopwatch) -> None:
    recorder = Recorder(file) if file else None
    run(request, [*([recorder] if recorder else []), *watching], [recorder.tap] if recorder else [])
    assert recorder is None or recorder.fault is None


def _simulated_s(file: Path) -> float:
    return read(file).ticks[-1].time


def _told(values: list[float]) -> tuple[str, str]:
    median, low, high = median_with_interval(values)
    return f"{median:.3f}", f"{low:.3f} to {high:.3f}"


def _tell_kills(file: Path, kills: int, moments: random.Random) -> float:
    """Print what killed processes left; return the most that was missing, in seconds."""
    missing = list(_missing_s(file, kills, moments))
    opened = [each for each in missing if each is not None]
    rows = [
        (
            "files that open, and can be replayed up to where they end",
            f"{len(opened)} of {kills}",
            f"{kills} of {kills}",
        ),
        ("missing at the end, median, s", f"{statistics.median(opened):.2f}", ""),
        ("missing at the end, worst, s", f"{max(opened):.2f}", f"≤ {LOST_BOUND_S:g}"),
    ]
    print_table((f"killed while recording, {kills} times", "", "bound"), rows)
    return max(opened) if len(opened) == kills else float("inf")


def _missing_s(file: Path, kills: int, moments: random.Random) -> Iterator[float | None]:
    for _ in range(kills):
        last = _killed_at(file, moments.uniform(0.5, 3.0))
        try:
            recording = read(file)
        except RecordingError:
            yield None
        else:
            ticks = recording.ticks
            assert recording.is_replayable or not ticks, recording.why_not
            yield last - (ticks[-1].time if ticks else 0.0)


def _killed_at(file: Path, moment: float) -> float:
    """Kill a process that has recorded for so long; return the time of its last tick."""
    command = [sys.executable, "-m", KILLED, str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603  our own
        assert process.stdout
        last = 0.0
        while last < moment:
            last = float(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
        rest = process.stdout.read().splitlines(keepends=True)
    return float(next((line for line in reversed(rest) if line.endswith("\n")), last))


if __name__ == "__main__":
    sys.exit(main())
