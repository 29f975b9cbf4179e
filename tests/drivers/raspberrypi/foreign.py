"""Device drivers of another package, and the rover with them."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import EntryPoint
from typing import Any

import pytest

from robotcore import plugins as registry
from robotcore.description import MotorDescription, RangeSensorDescription, RobotDescription, StrictModel, load_robot
from robotcore.hal.devices import Device
from robotcore.hardware import Connection, DeviceDriver, Host


class IrSettings(StrictModel):
    """The GPIO of its output; any number is valid, as in many drivers."""

    out: int


class IrSwitch(DeviceDriver[RangeSensorDescription, IrSettings]):
    """An infrared switch."""

    name = "ir-switch"
    summary = "for tests"
    described = RangeSensorDescription
    settings = IrSettings

    def connections(self, settings: IrSettings) -> Sequence[Connection]:
        return (Connection("out", "GPIO", str(settings.out)),)

    def open(self, description: RangeSensorDescription, settings: IrSettings, host: Host) -> Device:
        raise NotImplementedError


class Nothing(StrictModel):
    """No settings."""


class Hat(DeviceDriver[MotorDescription, Nothing]):
    """A motor on a board that is plugged onto the header."""

    name = "hat"
    summary = "for tests"
    described = MotorDescription
    settings = Nothing

    def open(self, description: MotorDescription, settings: Nothing, host: Host) -> Device:
        raise NotImplementedError


def install(monkeypatch: pytest.MonkeyPatch) -> None:
    """Add the drivers of this module to the installed drivers."""
    points = {group: dict(registry._points(group)) for group in (registry.BACKENDS, registry.DEVICES)}
    points[registry.DEVICES] |= {
        kind.name: EntryPoint(kind.name, f"{__name__}:{kind.__name__}", registry.DEVICES) for kind in (IrSwitch, Hat)
    }
    before = registry._points
    monkeypatch.setattr("robotcore.plugins._points", lambda group: points.get(group) or before(group))


def rover(**sections: dict[str, Any]) -> RobotDescription:
    """Return the rover with these tables in place of its own tables."""
    shipped = load_robot("rover")
    return shipped.model_copy(update={"backends": {"raspberrypi": {**shipped.backends["raspberrypi"], **sections}}})
