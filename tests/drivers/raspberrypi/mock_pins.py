"""Devices on mock pins."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gpiozero.pins.mock import MockFactory

from robotcore.description import DeviceDescription, RobotDescription
from robotcore.hal.clock import SteppedClock
from robotcore.hardware import DeviceContext, bind_devices
from tests.drivers.raspberrypi.motors.rig import rover


def build_robot(description: DeviceDescription, table: Mapping[str, Any]) -> RobotDescription:
    """Return a robot with one device. ``table`` is the device's table of the section ``[raspberrypi]``."""
    return rover({description.name: table}).model_copy(update={"devices": (description,)})


def open_device(
    description: DeviceDescription, table: Mapping[str, Any], pins: MockFactory, clock: SteppedClock | None = None
) -> Any:
    """Open a device with the driver of its table."""
    robot = build_robot(description, table)
    (binding,) = bind_devices(robot, "raspberrypi")
    return binding.open(DeviceContext(robot, clock or SteppedClock(20.0, lambda _steps: None), pins))
