"""Kinds as another package would define them: a tilt sensor, a gripper, and a thermometer that a run monitors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

import pytest

from robotcore import plugins
from robotcore.description import DeviceDescription, RobotDescription, load_robot
from robotcore.hal.device import Actuator, Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.kinds.motor import Motor


class TiltDescription(DeviceDescription):
    kind: Literal["tilt_sensor"] = "tilt_sensor"


@dataclass(frozen=True)
class Tilt:
    """A sample of a tilt sensor."""

    roll: Annotated[float, Unit("rad")]
    pitch: Annotated[float, Unit("rad")]
    steps: Annotated[int, Unit("")]
    time: float
    sequence: int


class TiltSensor(Sensor[Tilt]):
    kind = "tilt_sensor"


class GripperDescription(DeviceDescription):
    kind: Literal["gripper"] = "gripper"
    max_opening_m: float = 0.1

    def arguments(self) -> dict[str, Any]:
        return {"max_opening": self.max_opening_m}


class Gripper(Actuator[float]):
    kind = "gripper"

    def __init__(self, name: str, max_opening: float) -> None:
        super().__init__(name)
        self.max_opening = max_opening

    def _limit(self, command: float) -> float:
        return min(command, self.max_opening)


class ToolMotor(Motor):
    kind = "tool_motor"


class ToolMotorDescription(DeviceDescription):
    kind: Literal["tool_motor"] = "tool_motor"

    def arguments(self) -> dict[str, Any]:
        return {"max_velocity": 5.0}


class ThermometerDescription(DeviceDescription):
    kind: Literal["thermometer"] = "thermometer"


@dataclass(frozen=True)
class Temperature:
    """A sample of a thermometer."""

    label: str
    temperature: Annotated[float, Unit("°C")]
    time: float
    sequence: int


class Thermometer(Sensor[Temperature]):
    kind = "thermometer"
    is_monitored = True

    def find_problem(self, sample: Temperature) -> str:
        return "Let the motor cool down" if sample.temperature > 80 else ""


KINDS = {
    "tilt_sensor": Kind("a tilt sensor", TiltDescription, TiltSensor, Tilt),
    "gripper": Kind("a gripper", GripperDescription, Gripper),
    "tool_motor": Kind("a motor of a tool", ToolMotorDescription, ToolMotor),
    "thermometer": Kind("a thermometer", ThermometerDescription, Thermometer, Temperature),
}


def install(monkeypatch: pytest.MonkeyPatch) -> None:
    """Register the kinds."""
    load = plugins.load_registered

    def load_with_kinds(noun: str, group: str, name: str) -> Any:
        return KINDS[name] if group == plugins.KINDS and name in KINDS else load(noun, group, name)

    monkeypatch.setattr("robotcore.hal.kind.load_registered", load_with_kinds)


def rover_with(*devices: DeviceDescription) -> RobotDescription:
    """Return the description of the shipped rover with further devices."""
    rover = load_robot("rover")
    return rover.model_copy(update={"devices": (*rover.devices, *devices)})
