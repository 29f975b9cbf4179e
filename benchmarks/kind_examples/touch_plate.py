"""A plate at the front that detects contacts."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field

from robotcore.description import DeviceDescription
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.hal.simulation_state import SimulationState


class TouchPlateDescription(DeviceDescription):
    """The table of a touch plate in a robot's file."""

    kind: Literal["touch_plate"]
    width_rad: Annotated[float, Field(gt=0, le=6.3)] = 2.0

    def arguments(self) -> dict[str, Any]:
        return {"width": self.width_rad}


@dataclass(frozen=True, slots=True)
class Contact:
    """A sample of a touch plate."""

    is_touched: Annotated[bool, Unit("")]
    time: float
    sequence: int


class TouchPlate(Sensor[Contact]):
    """A plate that detects contacts. A driver for a board inherits it."""

    kind = "touch_plate"

    def __init__(self, name: str, width: float = 2.0) -> None:
        super().__init__(name)
        self.width = width


def simulate(plate: TouchPlateDescription, state: SimulationState) -> Callable[[float, int], Contact]:
    """Return a function that takes a sample from the true state of the robot."""

    def take(time: float, sequence: int) -> Contact:
        return Contact(any(abs(b) <= plate.width_rad / 2 for b in state.list_contact_bearings()), time, sequence)

    return take


KIND = Kind("a plate that detects contacts", TouchPlateDescription, TouchPlate, Contact, simulate)
