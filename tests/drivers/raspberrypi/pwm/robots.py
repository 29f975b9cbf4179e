"""Robots with motors and a servo on a PCA9685."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from robotcore.description import RobotDescription
from robotcore.hal.clock import SteppedClock
from robotcore.hardware import DeviceContext, bind_devices
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.servo import ServoDescription
from tests.drivers.raspberrypi.motors.rig import rover

MODEL = {"forward_rad_s": 10.0, "backward_rad_s": 10.0}
LEFT = {"driver": "pca9685-motor", "board": "adafruit-motor-hat", "motor": "M1", "model": MODEL}
RIGHT = {**LEFT, "motor": "M2"}
PAN = {"driver": "pca9685-servo", "address": 0x60, "channel": 15}


def build_robot(**tables: Mapping[str, Any]) -> RobotDescription:
    """Return a robot with a motor for each table, and with a servo for the table ``pan``."""
    limits = {"min_angle_rad": -1.0, "max_angle_rad": 1.0, "max_velocity_rad_s": 5.0}
    pan = ServoDescription.model_validate({"kind": "servo", "name": "pan", **limits})
    motor = MotorDescription(kind="motor", name="motor", max_velocity_rad_s=10.0)
    devices = [pan if name == "pan" else motor.model_copy(update={"name": name}) for name in tables]
    return rover(tables).model_copy(update={"devices": tuple(devices), "drive": None})


def build_context(robot: RobotDescription, **parts: Any) -> DeviceContext:
    return DeviceContext(robot, SteppedClock(20.0, lambda _steps: None), **parts)


def open_devices(robot: RobotDescription, context: DeviceContext) -> list[Any]:
    """Open the robot's devices in the order of its file."""
    return [binding.open(context) for binding in bind_devices(robot, "raspberrypi")]
