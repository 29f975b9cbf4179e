"""A bumper, which detects contacts in a sector of directions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field

from robotcore.description import SensorDescription
from robotcore.geometry import wrap_angle
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.hal.simulation_state import SimulationState
from robotcore.kinds.device_tests.contacts import test_contacts

__all__ = ["KIND", "Bumper", "BumperDescription", "Touch"]


class BumperDescription(SensorDescription):
    """A bumper, which detects contacts in a sector of directions.

    >>> import math
    >>> left = {"direction_rad": math.pi / 4, "width_rad": math.pi / 2}
    >>> BumperDescription(kind="bumper", name="left_bumper", **left).arguments()["direction"] > 0
    True
    """

    kind: Literal["bumper"]
    direction_rad: Annotated[float, Field(ge=-math.pi, le=math.pi)] = 0.0
    """The angle from the robot's x axis to the middle of the sector, in radians, positive to the left."""
    width_rad: Annotated[float, Field(gt=0, le=math.tau)] = math.pi
    """The full width of the sector, in radians."""

    def arguments(self) -> dict[str, Any]:
        return {"direction": self.direction_rad, "width": self.width_rad}


@dataclass(frozen=True, slots=True)
class Touch:
    """A sample of a bumper.

    >>> Touch(is_pressed=True, time=1.25, sequence=25)
    Touch pressed at 1.25 s
    """

    is_pressed: Annotated[bool, Unit("")]
    """Whether the bumper touches a body."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""


class Bumper(Sensor[Touch]):
    """A sensor that detects contacts with other bodies.

    ``direction`` is the angle from the robot's x axis to the middle of the sector in which it detects contacts, and
    ``width`` is the full width of the sector, both in radians. A positive direction is on the left.

    >>> from robotcore.testing import MockRobot
    >>> robot = MockRobot("tracer", readings={"left_bumper": True}).layered
    >>> {bumper.name: bumper.read().is_pressed for bumper in robot.all(Bumper)}
    {'left_bumper': True, 'right_bumper': False}
    >>> robot["left_bumper"].direction > 0  # on the left
    True
    """

    kind = "bumper"

    def __init__(self, name: str, *, direction: float = 0.0, width: float = math.pi) -> None:
        super().__init__(name)
        self.direction, self.width = direction, width


def simulate(bumper: BumperDescription, state: SimulationState) -> Callable[[float, int], Touch]:
    """Return a function that takes a sample: whether a contact's direction is in the bumper's sector."""

    def take(time: float, sequence: int) -> Touch:
        offsets = (wrap_angle(bearing - bumper.direction_rad) for bearing in state.list_contact_bearings())
        is_pressed = bumper.name in state.touches or any(abs(offset) <= bumper.width_rad / 2 for offset in offsets)
        return Touch(is_pressed, time, sequence)

    return take


KIND = Kind("a sensor of contacts", BumperDescription, Bumper, Touch, simulate, test_devices=test_contacts)
"""The kind `bumper`, which the entry point of this name refers to."""
