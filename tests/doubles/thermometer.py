"""A kind of another package: a thermometer, which a run reads by itself and no simulator has."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.metadata import EntryPoint
from typing import Annotated, Literal

import pytest

from robotcore import plugins as registry
from robotcore.description import DeviceDescription, RobotDescription, load_robot
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind


class ThermometerDescription(DeviceDescription):
    kind: Literal["thermometer"] = "thermometer"


@dataclass(frozen=True, slots=True)
class Temperature:
    """A sample of a thermometer."""

    label: str
    temperature: Annotated[float, Unit("°C")]
    time: float
    sequence: int


class Thermometer(Sensor[Temperature]):
    """A thermometer of a motor."""

    kind = "thermometer"
    is_monitored = True

    def find_problem(self, sample: Temperature) -> str:
        return "Let the motor cool down" if sample.temperature > 80 else ""


KIND = Kind("a thermometer", ThermometerDescription, Thermometer, Temperature)


def install(monkeypatch: pytest.MonkeyPatch) -> RobotDescription:
    """Register the kind, and return a rover with a thermometer ``engine``."""
    points = {**registry._points(registry.KINDS), "thermometer": EntryPoint("thermometer", f"{__name__}:KIND", "")}
    others = registry._points
    monkeypatch.setattr("robotcore.plugins._points", lambda group: points if group == registry.KINDS else others(group))
    rover = load_robot("rover")
    return rover.model_copy(update={"devices": (*rover.devices, ThermometerDescription(name="engine"))})
