"""Measure how exactly robots with different drives follow `set_velocity`, against the closed form.

    python -m benchmarks.drives
    python -m benchmarks.drives --backend mujoco --robots rover picar --goal 0.01

Each robot drives 1 m straight, arcs, and turns: by 2π on the spot, or a full circle if it cannot turn on the spot. A
measurement begins after 1 s of the same command, so that the wheels and the steering have settled. The error of the
path is the distance from the end of the closed form, divided by the length of the path. The error of the angle is
relative to the angle of the turn, and for a straight line in rad. The exit status is 1 if an error of the true pose
exceeds the goal.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator
from typing import ClassVar, NamedTuple

from benchmarks.report import print_machine, print_table
from robotcore import Behaviour, Robot, Role, Status
from robotcore.description import Floor, RobotDescription, Start, WorldDescription, load_robot
from robotcore.geometry import Pose, Twist
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.truth import TruthSource
from robotcore.runtime.layers.assembly import assemble
from robotcore.runtime.loop import Loop
from robotcore.runtime.needs import needed_devices

ROBOTS = ("rover", "freenove-4wd", "picar")
RATE_HZ = 20.0
SETTLING_TICKS = 20
SPEED_M_S = 0.2
RADIUS_M = 0.6
"""The radius of arcs and circles, in metres. All robots can steer so sharply."""

SPIN_RAD_S = 1.0
FIELD = WorldDescription(name="field", floor=Floor(length_m=40.0, width_m=40.0), start=Start())


class Motion(NamedTuple):
    """A motion at constant velocities for a number of ticks."""

    name: str
    twist: Twist
    ticks: int


class Errors(NamedTuple):
    """The errors of a pose at the end of a motion."""

    path: float
    """The distance from the right end, divided by the length of the path; in metres for a turn on the spot."""
    angle: float
    """The error of the heading, divided by the angle of the turn; in rad for a straight line."""


class Steady(Behaviour):
    """Drives at constant velocities, and stores the poses at the begin and the end of the measurement."""

    needs: ClassVar = {Role.DRIVE}

    def __init__(self, motion: Motion, truth: TruthSource) -> None:
        self._motion, self._truth = motion, truth
        self._tick = 0
        self.poses: list[tuple[Pose, Pose]] = []

    def step(self, robot: Robot) -> Status:
        if self._tick in (SETTLING_TICKS, SETTLING_TICKS + self._motion.ticks):
            self.poses.append((self._truth.pose(), robot.drive.pose))
        self._tick += 1
        robot.drive.set_velocity(*self._motion.twist)
        return Status.SUCCESS if len(self.poses) == 2 else Status.RUNNING


def main() -> int:
    """Measure all motions of the robots, and print a table and the greatest errors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--backend", default="kinematic", help="the simulator")
    parser.add_argument("--robots", nargs="+", default=ROBOTS, help="the names or the files of the robots")
    parser.add_argument("--goal", type=float, default=1e-6, help="the greatest error of the true pose")
    options = parser.parse_args()
    print_machine()
    rows, worst = [], 0.0
    for robot in map(load_robot, options.robots):
        for motion in list_motions(robot):
            truth, odometry = measure(robot, motion, options.backend)
            worst = max(worst, *truth)
            errors = [f"{error:.1e}" for error in (*truth, *odometry)]
            rows.append([robot.name, motion.name, *errors])
    print_table(["robot", "motion", "path", "angle", "path by odometry", "angle by odometry"], rows)
    print(f"\nThe greatest error of the true pose on {options.backend} is {worst:.1e}; the goal is {options.goal:g}.")
    return int(worst > options.goal)


def list_motions(robot: RobotDescription) -> Iterator[Motion]:
    """Yield the motions of a robot. Each lasts for whole ticks."""
    turn = SPEED_M_S / RADIUS_M
    yield Motion("1 m forward", Twist(SPEED_M_S, 0.0), 100)
    yield Motion("1 m backward", Twist(-SPEED_M_S, 0.0), 100)
    yield Motion("arc to the left", Twist(SPEED_M_S, turn), 100)
    yield Motion("arc to the right", Twist(SPEED_M_S, -turn), 100)
    yield Motion("arc backward", Twist(-SPEED_M_S, turn), 100)
    if robot.min_turn_radius_m:
        ticks = round(math.tau / turn * RATE_HZ)
        exact = math.tau / ticks * RATE_HZ
        yield Motion("full circle", Twist(exact * RADIUS_M, exact), ticks)
    else:
        ticks = round(math.tau / SPIN_RAD_S * RATE_HZ)
        yield Motion("2π on the spot", Twist(0.0, math.tau / ticks * RATE_HZ), ticks)


def measure(robot: RobotDescription, motion: Motion, backend: str) -> tuple[Errors, Errors]:
    """Drive a motion, and return the errors of the true pose and of the odometry."""
    raw = load_backend(backend).open(Setup(robot, FIELD, needed_devices(robot, [Role.DRIVE]), RATE_HZ))
    assert raw.truth, f"{backend} does not provide the true pose"
    behaviour = Steady(motion, raw.truth)
    try:
        Loop(assemble(raw, robot, RATE_HZ), behaviour, RATE_HZ, timeout=math.inf).run()
    finally:
        raw.close()
    truth, odometry = zip(*behaviour.poses, strict=True)
    return compute_errors(motion, *truth), compute_errors(motion, *odometry)


def compute_errors(motion: Motion, begin: Pose, end: Pose) -> Errors:
    """Return the errors of a motion from ``begin`` to ``end``."""
    seconds = motion.ticks / RATE_HZ
    length, angle = abs(motion.twist.linear) * seconds, motion.twist.angular * seconds
    right = begin.advance(motion.twist.linear * seconds, angle)
    off = abs(math.remainder(end.heading - right.heading, math.tau))
    return Errors(right.distance_to(end.x, end.y) / (length or 1.0), off / (abs(angle) or 1.0))


if __name__ == "__main__":
    sys.exit(main())
