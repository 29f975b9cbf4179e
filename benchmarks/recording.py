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
from time import perf_counter, thread_time
from typing import NamedTuple

from benchmarks.pairs import median_with_interval, paired_ratios
from benchmarks.report import at_least_one, machine, print_table
from robotcore.errors import RecordingError
from robotcore.recording import read
from robotcore.recording.recorder import Recorder
from robotcore.runtime.session import Run, RunRequest, RunResult, run
from robotcore.runtime.trace import TickRecord

WATCHED_S = 4.0
COST_BOUND, LOST_BOUND_S = 1.15, 1.0
KILLED = "tests.robotcore.recording.recording_run"


@dataclass
class Stopwatch:
    """An observer, the last one: how long each tick took from one sleep to the next, and of that the thread's own work.

    Both in ms.
    """

    def begin(self, run: Run) -> None:
        self.ticks: list[tuple[float, float]] = []
        step, behaviour = run.behaviour.step, run.behaviour

        def timed(robot: object) -> object:
            self._start = perf_counter(), thread_time()
            return step(robot)  # type: ignore[arg-type]

        behaviour.step = timed  # type: ignore[method-assign, assignment]

    def tick(self, record: TickRecord) -> None:
        began, work = self._start
        self.ticks.append((1e3 * (perf_counter() - began), 1e3 * (thread_time() - work)))

    def end(self, result: RunResult) -> None: ...


class Cost(NamedTuple):
    """What a pair of runs tells, as medians over its ticks in ms: without a recording, and how much more with one."""

    bare: float
    more: float
    more_work: float

    @property
    def ratio(self) -> float:
        """How long a tick with a recording is, in ticks without one."""
        return 1 + self.more / self.bare


def main() -> int:
    """Measure all three and print them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=at_least_one, default=16)
    parser.add_argument("--kills", type=at_least_one, default=50)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    print(machine())
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap"
        ratio = _tell_cost(file, asked.pairs)
        lost_s = _tell_kills(file, asked.kills, random.Random(asked.seed))
    return int(ratio > COST_BOUND or lost_s > LOST_BOUND_S)


def _tell_cost(file: Path, pairs: int) -> float:
    """Print what a recording costs; return how long a tick is with one, in ticks without one."""
    costs = [_cost(file, pair) for pair in range(pairs)]
    ratio = paired_ratios(lambda: _search_s(file), lambda: _search_s(None), pairs)
    size = file.stat().st_size
    rows = [
        ("a tick without a recording, ms", *_format_cells([cost.bare for cost in costs]), ""),
        ("a tick with one takes longer by, ms", *_format_cells([cost.more for cost in costs]), ""),
        ("a tick with one ÷ a tick without", *_format_cells([cost.ratio for cost in costs]), f"≤ {COST_BOUND:g}"),
        ("of that the control thread's own work, ms", *_format_cells([cost.more_work for cost in costs]), ""),
        ("a whole simulated search, with ÷ without", f"{ratio[0]:.3f}", f"{ratio[1]:.3f} to {ratio[2]:.3f}", ""),
        ("the file of that search, KB a simulated second", f"{size / 1e3 / _simulated_s(file):.0f}", "", ""),
    ]
    print_table((f"recording, {pairs} pairs", "median", "95 % interval of it", "bound"), rows)
    return statistics.median(cost.ratio for cost in costs)


def _cost(file: Path, pair: int) -> Cost:
    """Run the same twice, each time first what came second the last time; each tick is held to its like."""
    order = (file, None) if pair % 2 else (None, file)
    ticks = {where: _ticks_ms(where) for where in order}
    pairs = list(zip(ticks[None], ticks[file], strict=True))
    more = (statistics.median(with_it[of] - bare[of] for bare, with_it in pairs) for of in (0, 1))
    return Cost(statistics.median(wall for wall, _ in ticks[None]), *more)


def _ticks_ms(file: Path | None) -> list[tuple[float, float]]:
    watch = Stopwatch()
    _run(file, RunRequest("green-search", world="clutter", seed=1, timeout_s=WATCHED_S, realtime=True), watch)
    return watch.ticks[5:]


def _search_s(file: Path | None) -> float:
    start = perf_counter()
    _run(file, RunRequest("green-search", world="clutter", seed=1))
    return perf_counter() - start


def _run(file: Path | None, request: RunRequest, *watching: Stopwatch) -> None:
    recorder = Recorder(file) if file else None
    run(request, [*([recorder] if recorder else []), *watching], [recorder.layer] if recorder else [])
    assert recorder is None or recorder.failure is None


def _simulated_s(file: Path) -> float:
    return read(file).ticks[-1].time


def _format_cells(values: list[float]) -> tuple[str, str]:
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
