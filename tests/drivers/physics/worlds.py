"""Worlds and robots for the tests of drivers with a physics engine."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

from robotcore.description import (
    COLOURS,
    Ball,
    Box,
    Cylinder,
    Floor,
    Light,
    RobotDescription,
    Start,
    WorldDescription,
    load_robot,
)
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.robot import Robot
from robotcore.hal.truth import TruthSource
from robotcore.kinds.camera import CameraDescription
from robotcore.kinds.motor import MotorDescription
from robotcore.simulation.rigid_body import BodyCamera

Thing = Box | Cylinder | Ball

ROVER = load_robot("rover")
LOOKOUT = load_robot("lookout")


def world(*things: Thing, start: Start | None = None, light: Light | None = None) -> WorldDescription:
    """Return a floor with these things on it."""
    return WorldDescription(
        name="ground",
        floor=Floor(length_m=6.0, width_m=6.0),
        start=start or Start(),
        light=light or Light(),
        obstacles=tuple(thing for thing in things if not isinstance(thing, Ball)),
        targets=tuple(thing for thing in things if isinstance(thing, Ball)),
    )


def box(
    x: float, y: float = 0.0, *, length: float = 0.2, width: float = 2.0, height: float = 0.4, yaw: float = 0.0
) -> Box:
    size: dict[str, Any] = {"length_m": length, "width_m": width, "height_m": height}
    return Box(shape="box", name="box", colour=(200, 40, 20), x_m=x, y_m=y, yaw_rad=yaw, **size)


def post(x: float, y: float = 0.0, *, radius: float = 0.1) -> Cylinder:
    return Cylinder(shape="cylinder", name="post", colour=COLOURS["blue"], x_m=x, y_m=y, radius_m=radius, height_m=0.3)


def ball(x: float, y: float = 0.0) -> Ball:
    return Ball(name="ball", colour=COLOURS["green"], radius_m=0.1, x_m=x, y_m=y)


def setup(
    described: WorldDescription | None,
    *,
    robot: RobotDescription = ROVER,
    devices: Iterable[str] | None = None,
    **more: Any,
) -> Setup:
    """Return a setup with these devices, by default all."""
    names = [device.name for device in robot.devices] if devices is None else devices
    return Setup(robot, described, frozenset(names), **more)


class EngineTests:
    """The base class of the tests for every physics engine. A driver's subclass sets ``backend``."""

    backend: ClassVar[type[Backend]]

    def open_robot(
        self,
        *things: Thing,
        start: Start | None = None,
        robot: RobotDescription = ROVER,
        with_camera: bool = False,
    ) -> Robot:
        """Open a robot among these things. Its camera is opened only on request, because opening it takes time."""
        devices = [device.name for device in robot.devices if with_camera or not isinstance(device, CameraDescription)]
        return self.backend().open(setup(world(*things, start=start), robot=robot, devices=devices))

    def open_in_world(self, described: WorldDescription, **options: str) -> Robot:
        """Open the rover with all its devices in a world, with these options of the backend."""
        return self.backend().open(setup(described, options=options))


def get_camera(robot: Robot) -> BodyCamera:
    """Return the camera of the driver, whose ``numbers`` has the body of each pixel."""
    assert isinstance(robot.camera, BodyCamera)
    return robot.camera


def build_rover(**changes: float) -> RobotDescription:
    """Return the description of the rover with changed motors."""
    devices = [
        device.model_copy(update=changes) if isinstance(device, MotorDescription) else device
        for device in ROVER.devices
    ]
    return ROVER.model_copy(update={"devices": tuple(devices)})


def drive(robot: Robot, left: float, right: float, seconds: float) -> None:
    """Turn the wheels at these velocities, in rad/s, for some time."""
    robot.motors["left_motor"].set_velocity(left)
    robot.motors["right_motor"].set_velocity(right)
    robot.clock.sleep_until(robot.clock.now() + seconds)


def get_truth(robot: Robot) -> TruthSource:
    assert robot.truth is not None
    return robot.truth
