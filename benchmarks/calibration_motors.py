"""Calibrate the motors of robots whose files are wrong, and compare the files with the truth.

    python -m benchmarks.calibration_motors --robots 10 --seed 1 --drives 16

Each robot is a rover on virtualpi with two motors, whose dead band, lag and gains are drawn: the gains of both motors
and both directions differ by up to 10 %. `robotcore calibrate motors` measures them by the encoders, by an IMU with
noise and drift, and by a tape measure with errors of 2 mm, and of 0.5° when the robot is put on the line. The first
table has the greatest errors of each property.

The second table has drives over 2 m at 0.25 m/s before and after the calibration: how far the robot was aside in the
end. "by the commands" is `drive.set_velocity` without any correction. "by the odometry" is the manoeuvre `straight`,
which holds the heading by the encoders. The motors of "equal lags" differ in all but their lag. Motors with different
lags turn the robot when it starts, which no model of the motors corrects.

The exit status is 1 if a goal is missed: 5 % for each property by the encoders; and after that calibration 2 cm aside,
by the odometry, and by the commands with equal lags.
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import NamedTuple

from benchmarks.calibration_robots import KEYS, Patient, draw_patient, measure_aside_m, open_runner
from benchmarks.report import parse_options, print_table
from robotcore.calibration.corrections import apply_corrections
from robotcore.calibration.motors.measurement import Method, MotorResult, measure_motors
from robotcore.calibration.motors.motor_corrections import list_motor_corrections
from robotcore.description.editing import RobotEditor
from robotcore.sweep.engine import count_cores

GOAL, ASIDE_GOAL_M = 0.05, 0.02
DISTANCE_M, SPEED_M_S = 2.0, 0.25
PROPERTIES = (*KEYS, "lag_s")


class Case(NamedTuple):
    """A way to calibrate and to drive."""

    method: Method
    has_equal_lags: bool
    holds_heading: bool

    @property
    def has_goal(self) -> bool:
        """Whether the goal for the distance aside holds."""
        return self.method is Method.ENCODER and (self.has_equal_lags or self.holds_heading)

    def __str__(self) -> str:
        lags = "equal lags" if self.has_equal_lags else "all different"
        return f"{self.method.value}, {lags}, by the {'odometry' if self.holds_heading else 'commands'}"


CASES = [
    Case(method, has_equal_lags, holds_heading)
    for method in Method
    for has_equal_lags in (True, False)
    for holds_heading in ((False, True) if method is Method.ENCODER else (False,))
]


def main() -> int:
    """Calibrate, drive, and print the greatest errors."""
    options = parse_options(__doc__, robots=10, seed=1, drives=16)
    seeds = [options.seed + number for number in range(max(options.robots, options.drives))]
    errors, aside, is_missed = [], [], False
    with ProcessPoolExecutor(count_cores()) as pool:
        for method in Method:
            found = list(pool.map(partial(measure_errors, method), seeds[: options.robots]))
            worst = [max((abs(error) for each in found for error in each[key]), default=None) for key in PROPERTIES]
            is_missed |= method is Method.ENCODER and max(filter(None, worst)) > GOAL
            cells = ["" if each is None else f"{100 * each:.2f} %" for each in worst]
            errors.append([method.value, f"{2 * options.robots}", *cells])
        for case in CASES:
            drives = list(pool.map(partial(drive_straight, case), seeds[: options.drives]))
            before, after = zip(*drives, strict=True)
            is_missed |= case.has_goal and max(after) > ASIDE_GOAL_M
            cells = [f"{100 * each:.1f} cm" for each in (median(before), max(before), median(after), max(after))]
            aside.append([str(case), f"{len(drives)}", *cells])
    print_table(["greatest error", "motors", *PROPERTIES], errors)
    print()
    print_table(["aside after 2 m", "robots", "before, median", "worst", "after, median", "worst"], aside)
    return int(is_missed)


def measure_errors(method: Method, seed: int) -> dict[str, list[float]]:
    """Calibrate the robot of a seed, and return the errors of each property as shares of the true values."""
    errors: dict[str, list[float]] = {key: [] for key in PROPERTIES}
    with TemporaryDirectory() as folder:
        patient = draw_patient(Path(folder), seed, has_encoders=method is Method.ENCODER)
        for result in calibrate(patient, method, seed):
            curve, response = result.curve, result.response
            found = dict(zip(KEYS, (curve.dead_band, curve.forward, curve.backward), strict=True))
            found |= {"lag_s": response.lag} if response else {}
            for key, estimate in found.items():
                errors[key].append(estimate.value / patient.values[result.motor][key] - 1)
    return errors


def drive_straight(case: Case, seed: int) -> tuple[float, float]:
    """Return how far the robot of a seed is aside before and after its calibration, in metres."""
    has_encoders = case.method is Method.ENCODER
    with TemporaryDirectory() as folder:
        patient = draw_patient(
            Path(folder), seed, has_encoders=has_encoders, has_equal_lags=case.has_equal_lags
        )  # fmt: skip
        measure = partial(measure_aside_m, patient, DISTANCE_M, SPEED_M_S, holds_heading=case.holds_heading)
        before = measure()
        calibrate(patient, case.method, seed)
        return abs(before), abs(measure())


def calibrate(patient: Patient, method: Method, seed: int) -> list[MotorResult]:
    """Measure the motors of a robot, correct its file, and return the results."""
    runner = open_runner(patient, seed)
    results = measure_motors(runner, method)
    editor = RobotEditor(patient.own)
    apply_corrections(editor, [each for result in results for each in list_motor_corrections(result, runner.robot)])
    editor.write(runner.robot.backend.check)
    return results


if __name__ == "__main__":
    sys.exit(main())
