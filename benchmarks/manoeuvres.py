"""Measure by the true poses where manoeuvres end: straight, turn and arc, and squares of 1 m.

    python -m benchmarks.manoeuvres --runs 200 --squares 20 --seed 1 --backend mujoco
    python -m benchmarks.manoeuvres --runs 20 --robot freenove-4wd --rate 50

Each kind of manoeuvre has ``--runs`` random values. A robot that cannot turn on the spot drives no turns and squares. A
square is four sides of 1 m and four turns, and ends where it began. In half of the squares of a robot with encoders,
each wheel turns up to 5 % more or less than commanded.

The table has the greatest distance from the commanded end, the greatest error of the heading there, and the greatest
overshoot: how far the robot was beyond the end, divided by the way. The exit status is 1 if a goal is missed: 5 mm,
0.5° and 2 %; 1 cm for squares, 2 cm with gains; and no command that exceeds the limits of the drive.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from random import Random

from benchmarks.manoeuvre_runs import Manoeuvre, measure_run
from benchmarks.report import parse_options, print_table
from robotcore.description import RobotDescription, load_robot
from robotcore.sweep.engine import count_cores

GROUP = 10
"""The number of manoeuvres in a run. A run with more of them could leave the field."""

GAIN_ERROR = 0.05
GOAL_M, GOAL_RAD, GOAL_OVERSHOOT = 0.005, math.radians(0.5), 0.02
SQUARE_GOAL_M, GAINS_GOAL_M = 0.01, 0.02


def main() -> int:
    """Drive the manoeuvres, and print the greatest errors."""
    options = parse_options(__doc__, runs=200, squares=20, seed=1, backend="kinematic", robot="rover", rate=20.0)
    robot, draw = load_robot(options.robot), Random(options.seed)
    measure = partial(measure_run, robot, options.backend, options.rate)
    rows, is_missed = [], False
    with ProcessPoolExecutor(count_cores()) as pool:
        for name in ["straight", "arc"] if robot.min_turn_radius_m else ["straight", "turn", "arc"]:
            drawn = [draw_manoeuvre(name, draw, robot.min_turn_radius_m) for _ in range(options.runs)]
            groups = [drawn[index : index + GROUP] for index in range(0, len(drawn), GROUP)]
            runs = list(pool.map(measure, groups))
            distance, angle, overshoot, _ = map(max, zip(*(each for run in runs for each in run.errors), strict=True))
            mean_s = sum(each.seconds for run in runs for each in run.errors) / len(drawn)
            excesses = sum(run.excesses for run in runs)
            is_missed |= distance > GOAL_M or angle > GOAL_RAD or overshoot > GOAL_OVERSHOOT or excesses > 0
            errors = f"{math.degrees(angle):.2f}°", f"{100 * overshoot:.2f} %", f"{excesses}", f"{mean_s:.1f} s"
            rows.append([name, f"{len(drawn)}", f"{1000 * distance:.1f} mm", *errors])
        for name, goal, squares, gains in draw_squares(robot, options.squares, draw):
            runs = list(pool.map(measure, squares, gains))
            closing = max(run.closing for run in runs)
            is_missed |= closing > goal
            rows.append([name, f"{len(runs)}", f"{1000 * closing:.1f} mm", "", "", "", ""])
    labels = ["number", "distance", "heading", "overshoot", "beyond limits", "mean time"]
    print_table([f"{robot.name} on {options.backend}, {options.rate:g} Hz", *labels], rows)
    return int(is_missed)


def draw_manoeuvre(name: str, draw: Random, min_radius: float) -> Manoeuvre:
    """Draw the values of a manoeuvre. ``min_radius`` is that of the sharpest turn of the robot, in metres."""
    sign = draw.choice([-1.0, 1.0])
    match name:
        case "straight":
            return Manoeuvre(name, (sign * draw.uniform(0.1, 2.0),))
        case "turn":
            return Manoeuvre(name, (sign * draw.uniform(0.1, math.tau),))
    return Manoeuvre(name, (draw.uniform(max(0.2, 1.2 * min_radius), 1.0), sign * draw.uniform(0.3, math.tau)))


def draw_squares(
    robot: RobotDescription, count: int, draw: Random
) -> Iterator[tuple[str, float, list[list[Manoeuvre]], list[tuple[float, float]]]]:
    """Yield the name, the goal, the manoeuvres and the gains of the wheels for each kind of squares."""
    if robot.min_turn_radius_m:
        return
    sides = [draw.choice([-1.0, 1.0]) for _ in range(count)]
    squares = [[Manoeuvre("straight", (1.0,)), Manoeuvre("turn", (side * math.pi / 2,))] * 4 for side in sides]
    yield "square", SQUARE_GOAL_M, squares, [(1.0, 1.0)] * count
    if robot.drive and robot.drive.encoders:
        gains = [(1 + draw.uniform(-GAIN_ERROR, GAIN_ERROR), 1 + draw.uniform(-GAIN_ERROR, GAIN_ERROR)) for _ in sides]
        yield "square with gains", GAINS_GOAL_M, squares, gains


if __name__ == "__main__":
    sys.exit(main())
