"""Compare the path that a simulator's wheels drive with the closed form.

    python -m benchmarks.wheels --backends pybullet,kinematic

The robot drives on open ground, stops, and coasts to rest. A lag of its motors shifts the path in time only. Errors of
the position are in percent of the length, errors of the heading in percent of the turn. If the length or the turn is
zero, errors are in millimetres or milliradians.
"""

from __future__ import annotations

import argparse
import math
from typing import NamedTuple

from benchmarks.report import machine, print_table
from robotcore.description import Drive, Floor, RobotDescription, Start, WorldDescription, load_robot
from robotcore.geometry import Pose, Wheels, wrap_angle
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.devices import Motor
from robotcore.hal.robot import Robot

COASTING_S = 1.0


class Manoeuvre(NamedTuple):
    """A constant twist for a time, in m/s, rad/s and s."""

    name: str
    linear: float
    angular: float
    duration: float


MANOEUVRES = (
    Manoeuvre("1 m straight, 0.2 m/s", 0.2, 0.0, 5.0),
    Manoeuvre("2π on the spot in 4 s", 0.0, math.tau / 4, 4.0),
    Manoeuvre("arc, 0.15 m/s and 0.6 rad/s, 5 s", 0.15, 0.6, 5.0),
)


def main() -> None:
    """Drive every manoeuvre on every backend, and print the errors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--backends", default="pybullet,kinematic")
    parser.add_argument("--robot", default="rover", help="a robot's name or file")
    parser.add_argument("--rate", type=float, default=20.0, help="ticks a second")
    parser.add_argument("--heading", type=float, default=0.3, help="the heading at the start, in rad")
    options = parser.parse_args()
    print(machine())
    rows = [
        [
            backend,
            manoeuvre.name,
            *_measure_errors(backend, load_robot(options.robot), manoeuvre, options.rate, options.heading),
        ]
        for backend in options.backends.split(",")
        for manoeuvre in MANOEUVRES
    ]
    print_table(("backend", "manoeuvre", "place", "heading"), rows)


def _measure_errors(
    backend: str, description: RobotDescription, manoeuvre: Manoeuvre, rate: float, heading: float
) -> tuple[str, str]:
    assert description.drive, f"{description.name} has no drive to measure"
    start = Start(yaw_rad=heading)
    world = WorldDescription(name="ground", floor=Floor(length_m=6.0, width_m=6.0), start=start)
    wheels = frozenset((description.drive.left, description.drive.right))
    with load_backend(backend).open(Setup(description, world, wheels, rate)) as robot:
        reached = _drive(robot, description.drive, manoeuvre)
    length, turn = manoeuvre.linear * manoeuvre.duration, manoeuvre.angular * manoeuvre.duration
    meant = start.pose.advance(length, turn)
    return (
        _format_error(meant.distance_to(reached.x, reached.y), length, "mm"),
        _format_error(wrap_angle(reached.heading - meant.heading), turn, "mrad"),
    )


def _drive(robot: Robot, drive: Drive, manoeuvre: Manoeuvre) -> Pose:
    assert robot.truth, "only a simulator has the true pose"
    velocities = drive.geometry.to_wheels(manoeuvre.linear, manoeuvre.angular)
    for command, until in ((velocities, 0.0), (Wheels(0.0, 0.0), manoeuvre.duration)):
        robot.clock.sleep_until(until)
        for name, velocity in zip((drive.left, drive.right), command, strict=True):
            motor = robot[name]
            assert isinstance(motor, Motor)
            motor.set_velocity(velocity)
    robot.clock.sleep_until(manoeuvre.duration + COASTING_S)
    return robot.truth.pose()


def _format_error(error: float, whole: float, unit: str) -> str:
    return f"{100 * error / whole:+.3f} %" if whole else f"{1000 * error:+.3f} {unit}"


if __name__ == "__main__":
    main()
