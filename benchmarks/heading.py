"""Measure the heading error of 2 min of driving with encoders that slip, by the encoders alone and with an IMU.

    python -m benchmarks.heading --runs 20 --seed 1
    python -m benchmarks.heading --runs 5 --backend mujoco

The encoders miss 5 % of each turn of a wheel. The IMU has a bias of up to 0.02 rad/s, and noise of 0.001 rad/s in the
turn rate and of 0.001 rad in the heading. The robot stands for 2 s, then drives random arcs, and stands for 1 s in
every 20 s. The script prints the mean of the runs' root mean square errors, and their maximum. The exit status is 1 if
the mean error with the IMU is more than a fifth of the error by the encoders.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from importlib.resources import files
from pathlib import Path
from random import Random
from statistics import fmean
from tempfile import TemporaryDirectory
from typing import ClassVar

from benchmarks.report import parse_options, print_table
from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, Status, description, run
from robotcore.autonomy.heading import HeadingEstimator
from robotcore.geometry import Pose, wrap_angle
from robotcore.kinds import Imu
from robotcore.runtime.observer import RunContext
from robotcore.runtime.result import RunResult
from robotcore.runtime.trace import TickRecord
from robotcore.sweep.engine import count_cores

GOAL = 5.0
DRIVE_S = 120.0
PERIOD_S, REST_S, ARC_S = 20.0, 1.0, 3.0
MAX_BIAS_RAD_S = 0.02
IMU = """
[[devices]]
kind = "imu"
name = "imu"
yaw_rate_bias_rad_s = {bias}
yaw_rate_noise_rad_s = 0.001
heading_noise_rad = 0.001
"""

FIELD = """
name = "field"

[floor]
length_m = 40.0
width_m = 40.0
"""


class Wander(Behaviour):
    """Drives random arcs with rests, and estimates the heading."""

    needs: ClassVar = {Role.DRIVE, Imu}

    def __init__(self, seed: int) -> None:
        self.estimator = HeadingEstimator()
        self.pose = Pose(0.0, 0.0, 0.0)
        self._draw = Random(seed)
        self._arc, self._arc_until = (0.0, 0.0), 2.0

    def step(self, robot: Robot) -> Status:
        (imu,), now = robot.all(Imu), robot.clock.now()
        self.pose = robot.drive.pose
        self.estimator.update(self.pose, imu.read())
        if now >= DRIVE_S:
            return Status.SUCCESS
        if now >= self._arc_until:
            self._arc = self._draw.uniform(0.0, 0.2), self._draw.uniform(-0.8, 0.8)
            self._arc_until = now + ARC_S
        if now % PERIOD_S >= REST_S:
            robot.drive.set_velocity(*self._arc)
        return Status.RUNNING


class HeadingErrors:
    """An observer that adds up the squares of the heading errors."""

    def __init__(self) -> None:
        self.squares = [0.0, 0.0]
        self.ticks = 0

    def begin(self, run: RunContext) -> None:
        """Take the true heading of the start."""
        assert run.truth
        assert isinstance(run.behaviour, Wander)
        self._truth, self._app = run.truth, run.behaviour
        self._start = run.truth.pose.heading

    def tick(self, record: TickRecord) -> None:
        """Add the errors of the tick. The observer is called before simulated time advances."""
        true = self._truth.pose.heading - self._start
        for index, heading in enumerate((self._app.pose.heading, self._app.estimator.heading)):
            self.squares[index] += wrap_angle(heading - true) ** 2
        self.ticks += 1

    def end(self, result: RunResult) -> None: ...


def main() -> int:
    """Run the requests on all cores, and print the errors."""
    options = parse_options(__doc__, runs=20, backend="kinematic", seed=1)
    with TemporaryDirectory() as folder, ProcessPoolExecutor(count_cores()) as pool:
        requests = list(_draw_requests(options.runs, options.backend, Random(options.seed), Path(folder)))
        by_encoders, with_imu = zip(*pool.map(_measure_errors, requests), strict=True)
    ratio = fmean(by_encoders) / fmean(with_imu)
    rows = [
        (name, f"{fmean(errors):.4f} rad", f"{max(errors):.4f} rad")
        for name, errors in (("encoders", by_encoders), ("encoders and IMU", with_imu))
    ]
    print_table((f"{options.runs} runs on {options.backend}", "mean error", "largest error"), rows)
    print(f"The error with the IMU is {ratio:.1f} times smaller. The goal is {GOAL:g}.")
    return int(ratio < GOAL)


def _draw_requests(count: int, backend: str, draw: Random, folder: Path) -> Iterator[RunRequest]:
    """Draw the seed of each run and the bias of its IMU, and write their robots and world."""
    rover = (files(description) / "robots" / "rover.toml").read_text()
    world = folder / "field.toml"
    world.write_text(FIELD)
    for index in range(count):
        robot = folder / f"rover{index}.toml"
        robot.write_text(rover + IMU.format(bias=draw.uniform(-MAX_BIAS_RAD_S, MAX_BIAS_RAD_S)))
        seed = draw.randrange(100_000)
        yield RunRequest(
            Wander(seed),
            backend,
            str(robot),
            str(world),
            seed,
            timeout_s=DRIVE_S + 1,
            faults=("encoders slip=0.05",),
        )


def _measure_errors(request: RunRequest) -> tuple[float, float]:
    """Return the root mean square errors of the headings by the encoders and with the IMU, in radians."""
    errors = HeadingErrors()
    result = run(request, [errors])
    assert result.outcome is Outcome.SUCCESS, result
    by_encoders, with_imu = (math.sqrt(square / errors.ticks) for square in errors.squares)
    return by_encoders, with_imu


if __name__ == "__main__":
    sys.exit(main())
