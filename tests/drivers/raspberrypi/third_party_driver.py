"""A device driver of another package, and the rover with other drivers."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import EntryPoint
from typing import Any

import pytest

from robotcore import plugins as registry
from robotcore.description import RobotDescription, load_robot
from robotcore.hal.device import Device
from robotcore.hardware import Connection, DeviceContext, DeviceDriver
from robotcore.kinds.range_sensor import RangeSensorDescription


class IrSwitch(DeviceDriver):
    """An infrared switch. The number of its GPIO is not checked, as in many drivers."""

    name = "ir-switch"
    summary = "for tests"
    described = RangeSensorDescription

    out: int

    def connections(self) -> Sequence[Connection]:
        return (Connection("out", "GPIO", str(self.out)),)

    def open(self, description: RangeSensorDescription, context: DeviceContext) -> Device:
        raise NotImplementedError


def install(monkeypatch: pytest.MonkeyPatch) -> None:
    """Add the driver `IrSwitch` to the installed drivers."""
    found = registry._points
    own = {IrSwitch.name: EntryPoint(IrSwitch.name, f"{__name__}:IrSwitch", registry.DEVICES)}
    monkeypatch.setattr(
        "robotcore.plugins._points", lambda group: {**found(group), **(own if group == registry.DEVICES else {})}
    )


def rover(**sections: dict[str, Any]) -> RobotDescription:
    """Return the rover with these tables in place of its own tables."""
    shipped = load_robot("rover")
    return shipped.model_copy(update={"backends": {"raspberrypi": {**shipped.backends["raspberrypi"], **sections}}})
