"""Rules for batteries: a voltage that can be one, told again and again."""

from __future__ import annotations

import math

import pytest

from robotcore.hal.devices import Battery
from robotcore.hal.robot import Robot
from robotcore.testing.bench import Bench, let_pass

FRESH_S = 5.0
"""A battery changes in minutes: it may be told of more rarely than anything that a robot drives by."""


class BatteryRules(Bench):
    """What every battery owes whose voltage a board tells."""

    def test_voltage_is_a_number_above_zero(self) -> None:
        with self.opened() as robot:
            batteries = self._batteries(robot)
            let_pass(robot, FRESH_S)
            for battery in batteries:
                voltage = battery.read().voltage
                assert math.isfinite(voltage), f"{battery.name}: tells {voltage} V; raise DeviceError instead"
                assert voltage > 0, (
                    f"{battery.name}: tells {voltage} V, by which nothing would run; in volts, and above zero"
                )

    def test_battery_is_told_again(self) -> None:
        with self.opened() as robot:
            before = {battery.name: battery.read().time for battery in self._batteries(robot)}
            let_pass(robot, FRESH_S)
            for battery in self._batteries(robot):
                assert (time := battery.read().time) > before[battery.name], (
                    f"{battery.name}: {FRESH_S:g} s later the newest voltage is still of {time} s; ask for it again"
                )

    def _batteries(self, robot: Robot) -> list[Battery]:
        found = [device for device in robot.devices.values() if isinstance(device, Battery)]
        return found or pytest.skip(f"{self.backend.name} tells of no battery of {self.description.name}")
