"""Measure what a recording costs a loop, and how much of it a killed process loses.

    python -m benchmarks.recording

A robot with a camera of 320 × 240 searches for a ball at 20 Hz in real time. Each tick is timed from the beginning of
its step until the observers end, with a recording and without, in pairs. Then whole searches run at full speed. Then
recording processes are killed (SIGKILL) at random moments, and the time that the file lacks is measured. The exit
status is 1 if a bound is broken.
"""

from __future__ import annotations

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

from benchmarks.report import compute_median, measure_ratio, parse_options, print_table
from robotcore.errors import RecordingError
from robotcore.recording import read
from robotcore.recording.recorder import Recorder
from robotcore.runtime.session import RunContext, RunRequest, RunResult, run
from robotcore.runtime.trace import TickRecord

COST_BOUND, LOST_BOUND_S = 1.15, 1.0
KILLED = "tests.robotcore.recording.recording_run"


@dataclass
class Stopwatch:
    """An observer that measures each tick in ms: the wall time from the beginning of the step, and the CPU time."""

    def begin(self, run: RunContext) -> None:
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
    """The cost of a recording in a pair of runs, as medians over the ticks in ms."""

    bare: float
    more: float
    more_work: float

    @property
    def ratio(self) -> float:
        """The ratio of a tick with a recording to a tick without."""
        return 1 + self.more / self.bare


def main() -> int:
    """Measure the cost of recorded ticks, of recorded searches and of kills, and print them."""
    options = parse_options(__doc__, pairs=16, kills=50, seed=1, seconds=4.0, search=120.0)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.mcap"
        ratio = _print_cost(file, options.pairs, options.seconds, options.search)
        lost_s = _print_kills(file, options.kills, random.Random(options.seed))
    return int(ratio > COST_BOUND or lost_s > LOST_BOUND_S)


def _print_cost(file: Path, pairs: int, seconds: float, search: float) -> float:
    """Print the cost of a recording. Return the ratio between the times of a tick with and without a recording."""
    costs = [_compare_pair(file, pair, seconds) for pair in range(pairs)]
    ratio = measure_ratio(lambda: _time_search_s(file, search), lambda: _time_search_s(None, search), pairs)
    size = file.stat().st_size
    rows = [
        ("a tick without a recording, ms", *_format_cells([cost.bare for cost in costs]), ""),
        ("a tick with one takes longer by, ms", *_format_cells([cost.more for cost in costs]), ""),
        ("a tick with one ÷ a tick without", *_format_cells([cost.ratio for cost in costs]), f"≤ {COST_BOUND:g}"),
        ("of that the control thread's own work, ms", *_format_cells([cost.more_work for cost in costs]), ""),
        ("a whole simulated search, with ÷ without", *ratio.format_cells(".3f"), ""),
        ("the file of that search, KB a simulated second", f"{size / 1e3 / read(file).ticks[-1].time:.0f}", "", ""),
    ]
    print_table((f"recording, {pairs} pairs", "median", "95 % interval of it", "bound"), rows)
    return statistics.median(cost.ratio for cost in costs)


def _compare_pair(file: Path, pair: int, seconds: float) -> Cost:
    order = (file, None) if pair % 2 else (None, file)
    ticks = {where: _time_ticks_ms(where, seconds) for where in order}
    pairs = list(zip(ticks[None], ticks[file], strict=True))
    more = (statistics.median(with_it[of] - bare[of] for bare, with_it in pairs) for of in (0, 1))
    return Cost(statistics.median(wall for wall, _ in ticks[None]), *more)


def _time_ticks_ms(file: Path | None, seconds: float) -> list[tuple[float, float]]:
    watch = Stopwatch()
    _run(file, RunRequest("green-search", world="clutter", seed=1, timeout_s=seconds, realtime=True), watch)
    return watch.ticks[5:]


def _time_search_s(file: Path | None, search: float) -> float:
    start = perf_counter()
    _run(file, RunRequest("green-search", world="clutter", seed=1, timeout_s=search))
    return perf_counter() - start


def _run(file: Path | None, request: RunRequest, *watching: Stopwatch) -> None:
    recorder = Recorder(file) if file else None
    run(request, [*([recorder] if recorder else []), *watching], [recorder.layer] if recorder else [])
    assert recorder is None or recorder.failure is None


def _format_cells(values: list[float]) -> tuple[str, str]:
    return compute_median(values).format_cells(".3f")


def _print_kills(file: Path, kills: int, moments: random.Random) -> float:
    """Kill recording processes, and print how much their recordings lack. Return the largest loss in seconds."""
    missing = list(_measure_missing_s(file, kills, moments))
    opened = [each for each in missing if each is not None]
    rows = [
        ("files that open, and can be replayed to their end", f"{len(opened)} of {kills}", f"{kills} of {kills}"),
        ("missing at the end, median, s", f"{statistics.median(opened):.2f}", ""),
        ("missing at the end, worst, s", f"{max(opened):.2f}", f"≤ {LOST_BOUND_S:g}"),
    ]
    print_table((f"killed while recording, {kills} times", "", "bound"), rows)
    return max(opened) if len(opened) == kills else float("inf")


def _measure_missing_s(file: Path, kills: int, moments: random.Random) -> Iterator[float | None]:
    for _ in range(kills):
        last = _kill_recording(file, moments.uniform(0.5, 3.0))
        try:
            recording = read(file)
        except RecordingError:
            yield None
        else:
            ticks = recording.ticks
            assert recording.is_replayable or not ticks, recording.missing_inputs
            yield last - (ticks[-1].time if ticks else 0.0)


def _kill_recording(file: Path, moment: float) -> float:
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
