"""A sensor of the speed over the ground."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from robotcore.description import SensorDescription
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.simulation_state import SimulationState
from robotcore.hal.kind import Kind


class OldSensorDescription(SensorDescription):
    """The table of a speed sensor in a robot's file."""

    kind: Literal["old_sensor"]
    max_speed_m_s: Annotated[float, Field(gt=0, le=100)] = 1.0


@dataclass(frozen=True, slots=True)
class Speed:
    """A sample of a speed sensor."""

    speed: Annotated[float, Unit("m/s")]
    time: float
    sequence: int


class OldSensor(Sensor[Speed]):
    """A sensor of the speed over the ground. A driver for a board inherits it."""

    kind = "old_sensor"


def simulate(sensor: OldSensorDescription, state: SimulationState) -> Callable[[float, int], Speed]:
    """Return a function that takes a sample from the true state of the robot."""
    limit = sensor.max_speed_m_s

    def take(time: float, sequence: int) -> Speed:
        return Speed(max(-limit, min(state.twist().linear, limit)), time, sequence)

    return take


KIND = Kind("a sensor of the speed over the ground", OldSensorDescription, OldSensor, Speed, simulate)
