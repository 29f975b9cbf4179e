"""Run green-search while one wheel slips for a moment. It has to find the ball, and must not push against the guard.

    python -m benchmarks.slip --runs 200 --worlds arena,clutter --seed 1
    python -m benchmarks.slip --runs 40 --backend mujoco

A random encoder counts nothing for 0.3 to 0.8 s, from a random time between 1 and 20 s on. The heading by odometry is
wrong from then on. The script prints the share of runs whose success the simulator verified, with its confidence
interval, and the longest time for which a run asked for forward motion while the range guard held the robot. The exit
status is 1 if a goal is missed: 98 % verified, and at most 3 s.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from random import Random

from benchmarks.report import parse_options, print_table
from robotcore import RunRequest, run
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import Outcome, RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.sweep.engine import count_cores
from robotcore.sweep.statistics import wilson

GOAL = 0.98
PUSHING_S = 3.0


class HeldTime:
    """An observer that measures the longest time in which the range guard removed the app's forward motion."""

    def __init__(self) -> None:
        self.longest_s = 0.0
        self._since: float | None = None

    def begin(self, run: RunContext) -> None: ...

    def tick(self, record: TickRecord) -> None:
        """Measure the time since the guard began to hold the robot."""
        is_held = any(each.cause == "range guard" for each in record.interventions)
        self._since = (record.time if self._since is None else self._since) if is_held else None
        if self._since is not None:
            self.longest_s = max(self.longest_s, record.time - self._since)

    def end(self, result: RunResult) -> None: ...


def main() -> int:
    """Run the requests on all cores, and print the results."""
    options = parse_options(__doc__, runs=200, worlds="arena,clutter", backend="kinematic", seed=1)
    requests = list(_draw_requests(options.runs, options.worlds.split(","), options.backend, Random(options.seed)))
    with ProcessPoolExecutor(count_cores()) as pool:
        ends = list(zip(requests, pool.map(_run_request, requests), strict=True))
    for request, (is_verified, held_s) in ends:
        if not is_verified or held_s > PUSHING_S:
            print(f"inspect: {request}: verified {is_verified}, held {held_s:.1f} s")
    verified, longest_s = sum(is_verified for _, (is_verified, _) in ends), max(held_s for _, (_, held_s) in ends)
    low, high = wilson(verified, len(ends))
    row = options.backend, f"{verified}/{len(ends)}", f"{100 * low:.1f} to {100 * high:.1f} %", f"{longest_s:.1f} s"
    print_table(("backend", "verified", "95 % interval", "longest time against the guard"), [row])
    return int(verified < GOAL * len(ends) or longest_s > PUSHING_S)


def _draw_requests(count: int, worlds: list[str], backend: str, draw: Random) -> Iterator[RunRequest]:
    """Draw the world's seed, the wheel, the time and the duration of each run."""
    for index in range(count):
        side, after, lasts = draw.choice(["left", "right"]), draw.uniform(1, 20), draw.uniform(0.3, 0.8)
        fault = f"{side}_encoder slip=1 after={after:.2f} lasts={lasts:.2f}"
        world = worlds[index % len(worlds)]
        yield RunRequest("green-search", backend, world=world, seed=draw.randrange(100_000), faults=(fault,))


def _run_request(request: RunRequest) -> tuple[bool, float]:
    """Return whether the run is a verified success, and how long the range guard held the robot, in seconds."""
    held = HeldTime()
    result = run(request, [held])
    return result.verified is True and result.outcome is Outcome.SUCCESS, held.longest_s


if __name__ == "__main__":
    sys.exit(main())
