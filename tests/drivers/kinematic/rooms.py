"""Worlds and robots for the tests of the kinematic backend."""

from __future__ import annotations

from typing import Any

from drivers.kinematic.backend import KinematicBackend
from robotcore.description import (
    COLOURS,
    Ball,
    Box,
    Cylinder,
    Drive,
    Floor,
    RobotDescription,
    Start,
    Walls,
    WorldDescription,
    load_robot,
)
from robotcore.geometry import Wheels
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.hal.truth import TruthSource

ROVER = load_robot("rover")


def room(*things: Box | Cylinder | Ball, start: Start | None = None, walls: Walls | None = None) -> WorldDescription:
    """Return a floor of 4 m by 4 m with these things on it."""
    return WorldDescription(
        name="room",
        floor=Floor(length_m=4.0, width_m=4.0),
        walls=walls,
        start=start or Start(),
        obstacles=tuple(thing for thing in things if not isinstance(thing, Ball)),
        targets=tuple(thing for thing in things if isinstance(thing, Ball)),
    )


def box(
    x: float, y: float, length: float, width: float, *, height: float = 0.3, yaw: float = 0.0, name: str = "box"
) -> Box:
    size: dict[str, Any] = {"length_m": length, "width_m": width, "height_m": height}
    return Box(shape="box", name=name, colour=COLOURS["red"], x_m=x, y_m=y, yaw_rad=yaw, **size)


def post(x: float, y: float, radius: float, height: float = 0.3, name: str = "post") -> Cylinder:
    return Cylinder(shape="cylinder", name=name, colour=COLOURS["blue"], x_m=x, y_m=y, radius_m=radius, height_m=height)


def ball(x: float, y: float, radius: float = 0.1, name: str = "ball") -> Ball:
    return Ball(name=name, colour=COLOURS["green"], radius_m=radius, x_m=x, y_m=y)


def open_robot(
    world: WorldDescription | None = None,
    robot: RobotDescription = ROVER,
    devices: set[str] | None = None,
    rate_hz: float = 20.0,
    **options: Any,
) -> Robot:
    """Open a robot with these devices, by default all."""
    names = {device.name for device in robot.devices} if devices is None else devices
    setup = Setup(robot, world or room(), frozenset(names), rate_hz=rate_hz, options=options)
    return KinematicBackend().open(setup)


def build_rover(**motor: Any) -> RobotDescription:
    """Return the description of the rover with changed motors."""
    changed = tuple(d.model_copy(update=motor) if d.kind == "motor" else d for d in ROVER.devices)
    return ROVER.model_copy(update={"devices": changed})


def sleep(robot: Robot, seconds: float) -> None:
    robot.clock.sleep_until(robot.clock.now() + seconds)


def drive(robot: Robot, linear: float, angular: float, seconds: float) -> None:
    """Drive a rover at these velocities for some time, then stop it."""
    wheels = get_rover_drive().geometry.to_wheels(linear, angular)
    for motor, velocity in zip(robot.motors.values(), wheels, strict=True):
        motor.set_velocity(velocity)
    sleep(robot, seconds)
    for motor in robot.motors.values():
        motor.stop()


def get_rover_drive() -> Drive:
    assert ROVER.drive
    return ROVER.drive


def get_truth(robot: Robot) -> TruthSource:
    assert robot.truth
    return robot.truth


def read_wheel_angles(robot: Robot) -> Wheels:
    """Return the angles of a rover's encoders."""
    left, right = robot["left_encoder"], robot["right_encoder"]
    return Wheels(left.read().angle, right.read().angle)  # type: ignore[attr-defined]
