"""Measure how often follow-line follows a line that is drawn from a seed, by the simulators' true poses.

    python -m benchmarks.lines --runs 100 --seed 1
    python -m benchmarks.lines --runs 30 --backend mujoco --fault 'row noise=0.1'

Each line is closed, about 6 m long, and nowhere bent more than a circle of 0.2 m radius. The robot starts up to 2 cm
beside the line and up to 0.2 rad turned. A run counts if the robot's axle was nowhere farther than 5 cm from the line,
for a lap or for 5.85 m. `--noise` is that of the line sensors in the robot's file. `--randomise` draws the floor's
colour and pattern and the wheels too. The exit status is 1 if less than 98 % of the runs count.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from importlib.resources import files
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from benchmarks.report import parse_options, print_table
from robotcore import Outcome, RunRequest, description, run
from robotcore.geometry import Pose
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.sweep.engine import count_cores
from robotcore.sweep.statistics import wilson

GOAL = 0.98
RADIUS_M, MIN_RADIUS_M = 0.95, 0.2
POINTS, WAVES, WAVE = 120, (2, 3, 4, 5), 0.12
"""The number of points of a line, and the waves in its distance from the middle: their numbers, and their size."""

WORLD = """
name = "line"

[floor]
length_m = 4.0
width_m = 4.0
colour = "white"

[[lines]]
width_m = 0.02
closed = true
points_m = {points}

[variation]
place_x_m = [{start.x}, {start.x}]
place_y_m = [{start.y}, {start.y}]
yaw_rad = [{start.heading}, {start.heading}]

[randomisation]
colour_value = [0.6, 0.95]
colour_saturation = [0.0, 0.3]
pattern_contrast = [0.1, 0.3]
"""


class LineRun(NamedTuple):
    """The result of one run."""

    is_verified: bool
    max_distance: float
    """The largest distance of the axle's centre from the middle of the line, in metres."""
    description: str
    """The seed of the run, and how it ended."""


class LineDistance:
    """An observer that takes the largest distance from the line."""

    largest = 0.0

    def begin(self, run: RunContext) -> None:
        """Take the truth of the run."""
        assert run.truth
        self._truth = run.truth

    def tick(self, record: TickRecord) -> None:
        """Take the distance."""
        assert self._truth.line
        self.largest = self._truth.line.max_distance

    def end(self, result: RunResult) -> None: ...


def main() -> int:
    """Run the requests on all cores, and print the results."""
    options = parse_options(__doc__, runs=100, backend="kinematic", seed=1, fault="", noise=0.0, randomise=False)
    faults = (options.fault,) if options.fault else ()
    with TemporaryDirectory() as folder, ProcessPoolExecutor(count_cores()) as pool:
        robot = Path(folder) / "tracer.toml"
        tracer = (files(description) / "robots" / "tracer.toml").read_text()
        robot.write_text(tracer.replace("spacing_m = 0.012", f"spacing_m = 0.012\nnoise = {options.noise}"))
        requests = [
            RunRequest(
                "follow-line", options.backend, str(robot), str(world), seed, faults=faults, randomise=options.randomise
            )
            for world, seed in _write_worlds(options.runs, Random(options.seed), Path(folder))
        ]
        outcomes = list(pool.map(_follow, requests))
    verified, distances = (
        sum(outcome.is_verified for outcome in outcomes),
        [outcome.max_distance for outcome in outcomes],
    )
    low, high = wilson(verified, len(outcomes))
    columns = (f"{options.runs} lines on {options.backend}", "verified", "95 % interval", "distance: median", "largest")
    cells = f"{verified}/{len(outcomes)}", f"{100 * low:.1f} to {100 * high:.1f} %"
    centimetres = [f"{100 * distance:.1f} cm" for distance in (median(distances), max(distances))]
    print_table(columns, [(options.fault or f"noise {options.noise:g}", *cells, *centimetres)])
    for outcome in outcomes:
        if not outcome.is_verified:
            print(f"failing: {outcome.description}")
    return int(verified < GOAL * len(outcomes))


def _write_worlds(count: int, draw: Random, folder: Path) -> Iterator[tuple[Path, int]]:
    """Draw lines and starts. Yield each world's file and the seed of its run."""
    for index in range(count):
        world = folder / f"line{index}.toml"
        points = _draw_line(draw)
        (x, y), (next_x, next_y) = points[:2]
        along = Pose(x, y, math.atan2(next_y - y, next_x - x))
        start = Pose(*along.to_world(0.0, draw.uniform(-0.02, 0.02)), along.heading + draw.uniform(-0.2, 0.2))
        world.write_text(WORLD.format(points=points, start=start))
        yield world, draw.randrange(100_000)


def _draw_line(draw: Random) -> list[list[float]]:
    """Draw a closed line that is nowhere bent more than allowed. Return its points in metres."""
    turns = np.linspace(0.0, math.tau, POINTS, endpoint=False)
    while True:
        waves = [draw.uniform(0, WAVE) * np.cos(number * turns + draw.uniform(0, math.tau)) for number in WAVES]
        line = RADIUS_M * (1 + np.sum(waves, axis=0)) * np.exp(1j * turns)
        steps = np.roll(line, -1) - line
        bends = np.abs(np.angle(np.roll(steps, -1) / steps))
        if (np.abs(steps) / np.maximum(bends, 1e-9)).min() >= MIN_RADIUS_M:
            return [[round(float(x), 4), round(float(y), 4)] for x, y in zip(line.real, line.imag, strict=True)]


def _follow(request: RunRequest) -> LineRun:
    observer = LineDistance()
    result = run(request, [observer])
    is_verified = bool(result.outcome is Outcome.SUCCESS and result.verified)
    text = f"seed {request.seed}, {result.outcome.value} {result.reason}, floor {result.conditions.get('floor_value')}"
    return LineRun(is_verified, observer.largest, text)


if __name__ == "__main__":
    sys.exit(main())
