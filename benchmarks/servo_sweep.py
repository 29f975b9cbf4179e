"""Compare the distances that a range sensor on a servo measures to a wall with the closed form, in three simulators.

    python -m benchmarks.servo_sweep --sweeps 20 --seed 1

The robot stands in front of a wall. The servo turns the sensor from one side to the other. Its rate, and the distance
and direction of the wall are drawn from the seed. The sensor measures in each tick, also while the servo turns. The
closed form is the least distance from the sensor to the wall's line within the cone, at the angle that the servo's
rate gives. The cone is that of a laser, 0.01 rad, or of an ultrasonic sensor, 0.5 rad. The rays of a simulated sensor
begin 5 cm behind it, so a wide cone measures oblique walls too near. The exit status is 1 if an error is greater than
1 mm with the narrow cone, or 15 mm with the wide one.
"""

from __future__ import annotations

import math
import sys
from importlib.resources import files
from itertools import product
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import ClassVar, NamedTuple

from benchmarks.report import parse_options, print_table
from robotcore import Behaviour, Outcome, Robot, RunRequest, Status, description, run
from robotcore.geometry import Pose
from robotcore.kinds import RangeSensor, Servo

BOUNDS_M = {0.01: 0.001, 0.5: 0.015}
"""The greatest error in metres for each angle of the cone in radians."""

SIDE_RAD, REST_S = 0.9, 3.0
AXIS_X_M, AHEAD_M = 0.1, 0.04
"""The place of the servo on the robot, and the distance from its axis to the sensor."""

SERVO = """
[[devices]]
kind = "servo"
name = "pan"
mount = {{ x_m = {axis}, z_m = 0.1 }}
min_angle_rad = -1.5
max_angle_rad = 1.5
max_velocity_rad_s = {rate}
"""

WORLD = """
name = "wall"

[floor]
length_m = 12.0
width_m = 12.0

[[obstacles]]
name = "wall"
shape = "box"
colour = "white"
x_m = {middle.x}
y_m = {middle.y}
yaw_rad = {middle.heading}
length_m = 0.2
width_m = 6.0
height_m = 0.5
"""


class Sweep(NamedTuple):
    """The conditions of a sweep."""

    rate: float
    """The rate of the servo in rad/s."""
    distance: float
    """The distance from the robot's origin to the wall, in metres."""
    direction: float
    """The direction of the wall's perpendicular, in radians."""
    cone: float
    """The full angle of the sensor's cone in radians."""

    def compute_distance(self, angle: float) -> float:
        """Return the distance from the sensor to the wall within the cone, in metres, at an angle of the servo."""
        sensor = Pose(AXIS_X_M, 0.0, angle).compose(Pose(AHEAD_M, 0.0, 0.0))
        ahead = math.cos(self.direction) * sensor.x + math.sin(self.direction) * sensor.y
        aside = max(0.0, abs(angle - self.direction) - self.cone / 2)
        return (self.distance - ahead) / math.cos(aside)


class SweepServo(Behaviour):
    """Turns the servo to one side, then to the other, and stores the errors of the distances."""

    needs: ClassVar = {RangeSensor, "pan"}

    def __init__(self, sweep: Sweep) -> None:
        self.turning, self.resting = list[float](), list[float]()
        self._sweep, self._turned_at = sweep, math.inf

    def step(self, robot: Robot) -> Status:
        (pan,), now = robot.all(Servo), robot.clock.now()
        sample = robot.range.read()
        if now < REST_S:
            pan.set_angle(-SIDE_RAD)
        elif pan.angle < 0.0:
            pan.set_angle(SIDE_RAD)
            self._turned_at = now
        angle = min(-SIDE_RAD + self._sweep.rate * max(0.0, sample.time - self._turned_at), SIDE_RAD)
        is_turning = sample.time > self._turned_at and angle < SIDE_RAD
        if now > REST_S - 0.1:
            errors = self.turning if is_turning else self.resting
            errors.append(abs(sample.distance - self._sweep.compute_distance(angle)))
        return Status.SUCCESS if now > self._turned_at + 2 * SIDE_RAD / self._sweep.rate + 0.2 else Status.RUNNING


def main() -> int:
    """Sweep the walls in each simulator, and print the greatest errors."""
    options = parse_options(__doc__, sweeps=20, seed=1, backends="kinematic,mujoco,pybullet")
    rows, is_met = [], True
    for backend, (cone, bound) in product(options.backends.split(","), BOUNDS_M.items()):
        draw = Random(options.seed)
        with TemporaryDirectory() as folder:
            looks = [_sweep_wall(backend, cone, draw, Path(folder)) for _ in range(options.sweeps)]
        turning = [error for look in looks for error in look.turning]
        greatest = max(turning), max(error for look in looks for error in look.resting)
        cells = (f"{1000 * error:.2f} mm" for error in greatest)
        rows.append((backend, f"{cone:g} rad", str(len(turning)), *cells, f"{1000 * bound:g} mm"))
        is_met &= max(greatest) <= bound
    print_table(("backend", "cone", "samples while turning", "greatest error while turning", "at rest", "bound"), rows)
    return int(not is_met)


def _sweep_wall(backend: str, cone: float, draw: Random, folder: Path) -> SweepServo:
    sweep = Sweep(draw.uniform(0.7, 4.0), draw.uniform(0.6, 0.9), draw.uniform(-0.1, 0.1), cone)
    rover = (files(description) / "robots" / "rover.toml").read_text()
    nose, rest = rover.split('name = "nose"\n', 1)
    place = f'mount = {{ x_m = {AXIS_X_M + AHEAD_M}, z_m = 0.10, on = "pan" }}\n'
    keys = "min_range_m = 0.02\nmax_range_m = 4.0\n"
    after = rest[rest.index("\n\n") :]
    robot, world = folder / "panning.toml", folder / "wall.toml"
    servo = SERVO.format(axis=AXIS_X_M, rate=sweep.rate)
    table = f'{nose}name = "nose"\n{place}{keys}cone_rad = {sweep.cone}'
    tables, marker, boards = (table + after).partition("# On a Raspberry Pi")
    robot.write_text(tables + servo + "\n" + marker + boards)
    far = sweep.distance + 0.1
    middle = Pose(far * math.cos(sweep.direction), far * math.sin(sweep.direction), sweep.direction)
    world.write_text(WORLD.format(middle=middle))
    look = SweepServo(sweep)
    result = run(RunRequest(look, backend, str(robot), str(world), timeout_s=30.0))
    assert result.outcome is Outcome.SUCCESS, result
    return look


if __name__ == "__main__":
    sys.exit(main())
