"""A kinematic backend whose rover has a battery. The voltages follow a script."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import EntryPoint
from importlib.resources import files
from pathlib import Path
from typing import Any, ClassVar

import pytest

from drivers.kinematic.backend import KinematicBackend
from robotcore import plugins as registry
from robotcore.description import RobotDescription, load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.kinds.battery import BatteryDescription
from robotcore.testing.mock.devices import Script, open_sensor

CELLS = '\n[[devices]]\nkind = "battery"\nname = "cells"\nwarn_below_v = 6.6\n'
"""The section of a battery in a robot's file, without a section for a backend."""


def load_battery_rover(folder: Path) -> RobotDescription:
    """Write the file of the shipped rover with a battery, and load it."""
    file = folder / "battery_backend.toml"
    file.write_text(files("robotcore.description").joinpath("robots", "rover.toml").read_text() + CELLS)
    return load_robot(str(file))


class BatteryBackend(KinematicBackend):
    """Opens each battery with the voltages ``volts``. If ``volts`` is None, the batteries cannot be opened."""

    name = "powered"
    volts: ClassVar[Any] = 7.4

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return frozenset(device.name for device in robot.devices)

    def open(self, setup: Setup) -> Robot:
        names = {battery.name for battery in setup.robot.all_of(BatteryDescription)} & setup.devices
        raw = super().open(replace(setup, devices=setup.devices - names))
        if self.volts is None:
            return Robot(raw.name, raw.clock, raw.devices.values(), notes=[f"{name}: no answer" for name in names])
        described = [each for each in setup.chosen_devices if each.name in names]
        batteries = [open_sensor(each, self.volts, raw.clock, setup.rate_hz) for each in described]
        return Robot(raw.name, raw.clock, [*raw.devices.values(), *batteries], truth=raw.truth)


def install(monkeypatch: pytest.MonkeyPatch, volts: Script = 7.4) -> None:
    """Register the backend under the name ``powered``, with batteries that follow the script."""
    points = dict(registry._points(registry.BACKENDS))
    points["powered"] = EntryPoint("powered", f"{__name__}:BatteryBackend", registry.BACKENDS)
    others = registry._points
    monkeypatch.setattr(
        "robotcore.plugins._points", lambda group: points if group == registry.BACKENDS else others(group)
    )
    monkeypatch.setattr(BatteryBackend, "volts", staticmethod(volts) if callable(volts) else volts)
