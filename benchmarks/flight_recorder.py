"""Measure the flight recorder: its size in a long run, and its end after kills.

    python -m benchmarks.flight_recorder

An app that drives for two hours at full speed is recorded with a size limit, and the size of all files of the recording
is measured every 50 ms. Then recording processes run in real time, longer than their ring, and are killed (SIGKILL) at
random moments. The recordings must have the last minute, and at most a second may be missing at the end. The exit
status is 1 if a bound is broken.
"""

from __future__ import annotations

import math
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from benchmarks.report import parse_options, print_table
from robotcore.errors import RecordingError
from robotcore.recording import read
from robotcore.recording.recorder import Recorder
from robotcore.recording.segments import locate_segments
from robotcore.runtime.session import RunRequest, run

LOST_BOUND_S, WATCH_S = 1.0, 0.05
PROCESSES = 13
KILLED = "tests.robotcore.recording.recording_run"


class Kill(NamedTuple):
    """A killed recording."""

    missing_s: float
    """The time between the last tick of the process and the last tick in the file, in seconds."""
    kept_s: float
    """The time between the first and the last tick in the file, in seconds."""


def main() -> int:
    """Measure the size and the kills, and print them."""
    options = parse_options(__doc__, hours=2.0, limit=20.0, last=3600.0, kills=50, ring=60.0, seed=1)
    with tempfile.TemporaryDirectory() as folder:
        is_within = _print_size(Path(folder), options.hours * 3600, int(options.limit * 1e6), options.last)
        is_kept = _print_kills(Path(folder), options.kills, options.ring, random.Random(options.seed))
    return int(not (is_within and is_kept))


def _print_size(folder: Path, duration: float, limit: int, last: float) -> bool:
    file, sizes, has_ended = folder / "long.mcap", [0], threading.Event()

    def watch() -> None:
        while not has_ended.wait(WATCH_S):
            sizes.append(sum(map(_measure, (file, *locate_segments(file).glob("*")))))

    watcher = threading.Thread(target=watch)
    watcher.start()
    began = perf_counter()
    recorder = Recorder(file, last_s=last, limit=limit)
    request = RunRequest("avoid-obstacles", settings={"duration_s": duration}, timeout_s=duration + 1)
    result = run(request, [recorder], [recorder.layer])
    has_ended.set()
    watcher.join()
    assert recorder.failure is None
    assert result.sim_time_s >= duration
    recording = read(file)
    kept = recording.ticks[-1].time - recording.ticks[0].time
    largest = max(*sizes, file.stat().st_size)
    rows = [
        ("robot's time, s", f"{result.sim_time_s:.0f}", ""),
        ("speed, times real time", f"{result.sim_time_s / (perf_counter() - began):.0f}", ""),
        ("largest size of all files, MB", f"{largest / 1e6:.2f}", f"≤ {limit / 1e6:g}"),
        ("the file, MB", f"{file.stat().st_size / 1e6:.2f}", ""),
        ("the recording has the last … s", f"{kept:.1f}", f"≥ {min(last, duration):g}, or the limit is reached"),
    ]
    print_table((f"a ring of {last:g} s in a limit of {limit / 1e6:g} MB", "", "bound"), rows)
    return largest <= limit and (kept >= min(last, duration) or largest > limit / 2)


def _measure(file: Path) -> int:
    with suppress(FileNotFoundError):  # the ring has deleted it in the meantime
        return file.stat().st_size
    return 0


def _print_kills(folder: Path, kills: int, ring: float, moments: random.Random) -> bool:
    """Kill recording processes, and print how much their recordings have and lack. Return whether the bounds hold."""
    found = _kill_all(folder, kills, ring, moments)
    kept = [each.kept_s for each in found if each]
    missing = [each.missing_s for each in found if each] or [math.inf]
    whole = sum(each >= ring for each in kept)
    rows = [
        (f"files with the last {ring:g} s", f"{whole} of {kills}", f"{kills} of {kills}"),
        ("kept, least, s", f"{min(kept, default=0.0):.2f}", f"≥ {ring:g}"),
        ("missing at the end, median, s", f"{statistics.median(missing):.2f}", ""),
        ("missing at the end, worst, s", f"{max(missing):.2f}", f"≤ {LOST_BOUND_S:g}"),
    ]
    print_table((f"a ring of {ring:g} s, killed {kills} times", "", "bound"), rows)
    return whole == kills and max(missing) <= LOST_BOUND_S


def _kill_all(folder: Path, kills: int, ring: float, moments: random.Random) -> list[Kill | None]:
    """Record in up to `PROCESSES` processes at once, and kill each at its own moment after its ring is full."""
    files = [folder / f"killed-{number}.mcap" for number in range(kills)]
    times = [moments.uniform(1.2, 1.8) * ring for _ in files]
    with ThreadPoolExecutor(PROCESSES) as executor:
        return list(executor.map(partial(_kill, ring), files, times))


def _kill(ring: float, file: Path, after_s: float) -> Kill | None:
    command = [sys.executable, "-m", KILLED, str(file), str(ring)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603  our own
        assert process.stdout
        last = 0.0
        while last < after_s:
            last = float(process.stdout.readline())
        process.send_signal(signal.SIGKILL)
        rest = process.stdout.read().splitlines(keepends=True)
        last = float(next((line for line in reversed(rest) if line.endswith("\n")), last))
    try:
        ticks = read(file).ticks
    except RecordingError:
        return None
    return Kill(last - ticks[-1].time, ticks[-1].time - ticks[0].time) if ticks else None


if __name__ == "__main__":
    sys.exit(main())
