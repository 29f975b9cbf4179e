"""Run green-search while one wheel slips for a moment. It has to find the ball, and must not push against the guard.

    python -m benchmarks.slip --runs 200 --worlds arena,clutter --seed 1
    python -m benchmarks.slip --runs 40 --backend mujoco

A random encoder counts nothing for 0.3 to 0.8 s, from a random time between 1 and 20 s on. The heading by odometry is
wrong from then on. The script prints the share of runs whose success the simulator verified, with its confidence
interval, and the longest time for which a run asked for forward motion while the range guard held the robot. The exit
status is 1 if a goal is missed: 98 % verified, and at most 3 s.
"""

from __future__ import annotations

import argparse
import random
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass

from robotcore import RunRequest, run
from robotcore.runtime.observer import Run
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

    def begin(self, run: Run) -> None:
        """Do nothing."""

    def tick(self, record: TickRecord) -> None:
        """Measure the time since the guard began to hold the robot."""
        is_held = any(each.cause == "range guard" for each in record.interventions)
        self._since = (record.time if self._since is None else self._since) if is_held else None
        if self._since is not None:
            self.longest_s = max(self.longest_s, record.time - self._since)

    def end(self, result: RunResult) -> None:
        """Do nothing."""


@dataclass(frozen=True)
class RunEnd:
    """The end of one run."""

    request: RunRequest
    is_verified: bool
    longest_held_s: float
    headline: str


def draw_requests(count: int, worlds: list[str], backend: str, seed: int) -> list[RunRequest]:
    """Draw the world's seed, the wheel, the time and the duration of each run."""
    draw = random.Random(seed)
    requests = []
    for index in range(count):
        side, after, lasts = draw.choice(["left", "right"]), draw.uniform(1, 20), draw.uniform(0.3, 0.8)
        fault = f"{side}_encoder slip=1 after={after:.2f} lasts={lasts:.2f}"
        world = worlds[index % len(worlds)]
        requests.append(RunRequest("green-search", backend, world=world, seed=draw.randrange(100_000), faults=(fault,)))
    return requests


def try_request(request: RunRequest) -> RunEnd:
    """Run a request and measure how long the range guard held the robot."""
    held = HeldTime()
    result = run(request, [held])
    is_verified = result.verified is True and result.outcome is Outcome.SUCCESS
    return RunEnd(request, is_verified, held.longest_s, f"{result.outcome.value} after {result.sim_time_s:.1f} s")


def main() -> int:
    """Run the requests on all cores and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--worlds", default="arena,clutter")
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.runs < 1:
        parser.error("--runs must be at least 1")
    requests = draw_requests(options.runs, options.worlds.split(","), options.backend, options.seed)
    with ProcessPoolExecutor(count_cores()) as pool:
        ends = list(pool.map(try_request, requests))
    for end in ends:
        if not end.is_verified or end.longest_held_s > PUSHING_S:
            request = end.request
            print(
                f"{request.world} seed {request.seed} --fault '{request.faults[0]}': {end.headline}, "
                f"verified {end.is_verified}, held {end.longest_held_s:.1f} s"
            )
    verified = sum(end.is_verified for end in ends)
    longest = max(end.longest_held_s for end in ends)
    low, high = wilson(verified, len(ends))
    print(f"{options.backend}: {verified} of {len(ends)} verified, 95 % interval {low:.3f} to {high:.3f}")
    print(f"longest time against the guard: {longest:.1f} s")
    return 0 if verified >= GOAL * len(ends) and longest <= PUSHING_S else 1


if __name__ == "__main__":
    sys.exit(main())
