from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from robotcore.description import BatteryDescription, RobotDescription, load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.devices import Battery, Voltage
from robotcore.hal.robot import Robot
from tests.doubles.powered import PoweredBackend
from tests.robotcore.testing.broken.sensing import saying
from tests.robotcore.testing.harness import Broken, Sound

ROVER = load_robot("rover")
POWERED = ROVER.model_copy(update={"devices": (*ROVER.devices, BatteryDescription(kind="battery", name="cells"))})


class Powered(Sound):
    """The suite on a robot with a battery."""

    backend = PoweredBackend

    @property
    def description(self) -> RobotDescription:
        return POWERED


def broken(fault: str, rules: str, change: Callable[[Voltage], Voltage]) -> Broken:
    class Suite(Powered):
        def open(self, setup: Setup) -> Robot:
            robot = super().open(setup)
            saying(Battery, change)(robot)
            return robot

    return Broken(fault, frozenset(rules.split()), Suite)


BROKEN = (
    broken(
        "a battery that cannot be read has zero volts",
        "voltage_is_a_number_above_zero",
        lambda sample: replace(sample, voltage=0.0),
    ),
    broken(
        "a battery that cannot be read has nan volts",
        "voltage_is_a_number_above_zero",
        lambda sample: replace(sample, voltage=math.nan),
    ),
    broken("a battery is asked once", "battery_is_told_again", lambda _: Voltage(7.4, 0.0, 0)),
)
