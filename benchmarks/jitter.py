"""Measure the jitter of the ticks of a run in real time, with and without --rt, while all processors are busy.

    python -m benchmarks.jitter --rounds 5 --seconds 10

In each round, a run of a robot with a guardian, and with encoders that are read 200 times in a second, is executed in
each way in turn, at 20 and at 50 Hz. Other programs use every processor meanwhile, one each. The jitter is the
difference between the time from tick to tick and the period. "pinned" also binds the tick's thread to one processor.
The exit status is 1 if the system grants no real-time priority, or if --rt does not lower the 99th percentile.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

from benchmarks.report import parse_options, print_table
from drivers.raspberrypi.loopback.processes import load_processors
from drivers.raspberrypi.loopback.ticks import Jitter

RATES_HZ = (20, 50)
WAYS = {
    "normal": {"rt": False, "is_pinned": False},
    "--rt": {"rt": True, "is_pinned": False},
    "--rt, pinned": {"rt": True, "is_pinned": True},
}


def main() -> int:
    """Execute the runs in turn, and print the jitter of each way."""
    options = parse_options(__doc__, rounds=5, seconds=10.0)
    found: dict[tuple[int, str], list[dict[str, Any]]] = {(rate, way): [] for rate in RATES_HZ for way in WAYS}
    with load_processors():
        for _ in range(options.rounds):
            for (rate, way), runs in found.items():
                runs.append(_run_once(rate, way, max(2, round(options.seconds * rate))))
    rows, p99, is_granted = [], {}, True
    for (rate, way), runs in found.items():
        jitter = Jitter.from_runs([run["times"] for run in runs], rate)
        p99[rate, way] = jitter.percentiles.p99
        is_granted &= WAYS[way]["rt"] is False or all(run["priority"] for run in runs)
        cells = [f"{value * 1e3:.2f}" for value in jitter.percentiles]
        rows.append((str(rate), way, str(jitter.ticks), *cells, str(jitter.late_ticks)))
    print_table(("Hz", "way", "ticks", "p50, ms", "p99, ms", "worst, ms", "late by half a period"), rows)
    return int(not is_granted or any(p99[rate, "--rt"] >= p99[rate, "normal"] for rate in RATES_HZ))


def _run_once(rate: int, way: str, ticks: int) -> dict[str, Any]:
    wanted = json.dumps({"rate_hz": rate, "ticks": ticks, **WAYS[way]})
    command: Sequence[str] = [sys.executable, "-m", "benchmarks.timed_ticks", wanted]
    run = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)  # noqa: S603  our own
    result: dict[str, Any] = json.loads(run.stdout)
    return result


if __name__ == "__main__":
    sys.exit(main())
