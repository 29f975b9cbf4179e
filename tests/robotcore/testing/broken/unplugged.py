"""Drivers whose hardware the suite unplugs, and which hide the errors of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from robotcore.errors import DeviceError
from robotcore.hal.device import Sensor
from robotcore.hal.robot import Robot
from robotcore.kinds.motor import Motor
from tests.robotcore.testing.harness import Sound, broken, replace_attribute


class UnpluggedSuite(Sound):
    """A suite that can unplug the hardware. The devices of the classes ``silent`` then raise no error."""

    silent: tuple[type[object], ...] = ()

    def unplug(self, robot: Robot) -> None:
        for device in robot.devices.values():
            if isinstance(device, (Motor, Sensor)) and not isinstance(device, self.silent):
                hook = "_apply" if isinstance(device, Motor) else "_newest"
                replace_attribute(device, hook, _build_failure(device.name))


def _build_failure(device: str) -> Callable[..., Any]:
    def fail(*_arguments: Any) -> None:
        raise DeviceError(device, "the board does not answer")

    return fail


class SilentMotorSuite(UnpluggedSuite):
    silent = (Motor,)


class SilentSensorSuite(UnpluggedSuite):
    silent = (Sensor,)


BROKEN = (
    broken(
        "motors hide errors",
        "command_to_unplugged_hardware_is_an_error closing_unplugged_hardware_is_an_error",
        suite=SilentMotorSuite,
    ),
    broken("sensors hide errors", "reading_unplugged_hardware_is_an_error", suite=SilentSensorSuite),
)
