"""The person who drives a robot, as a sensor: its samples are the person's commands.

So a recording has the commands, a replay repeats them, and faults can lose them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from robotcore.description import DeviceDescription
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.text import format_number

__all__ = ["KIND", "Operator", "OperatorCommand", "OperatorDescription", "OperatorSample"]


class OperatorDescription(DeviceDescription):
    """The person who drives a robot. A run with ``has_operator`` adds this device, so no robot's file has it.

    >>> OperatorDescription(kind="operator", name="operator")
    OperatorDescription(kind='operator', name='operator')
    """

    kind: Literal["operator"]


@dataclass(frozen=True, slots=True)
class OperatorCommand:
    """The newest command of the person to an actuator outside the drive.

    >>> OperatorCommand(device="pan", value=(0.5,), number=1)
    OperatorCommand(device='pan', value=(0.5,), number=1)
    """

    device: str
    value: tuple[float, ...]
    """One number for an actuator such as a servo, three for the colours of a light."""
    number: int
    """The number of the command, from 1. A greater number is a later command, possibly with the same value."""


@dataclass(frozen=True, slots=True)
class OperatorSample:
    """The commands of the person at one time.

    >>> OperatorSample(is_driving=True, is_silent=False, linear=0.2, angular=0.5, commands=(), time=1.0, sequence=20)
    OperatorSample 0.20 m/s, 0.50 rad/s at 1.00 s
    """

    is_driving: Annotated[bool, Unit("")]
    """Whether the person drives. The run then does not call the app."""
    is_silent: Annotated[bool, Unit("")]
    """Whether the person drives, but has sent no velocity for longer than the lease. The wheels then stop."""
    linear: Annotated[float, Unit("m/s")]
    """The forward velocity that the person commands; 0 if the person is silent or does not drive."""
    angular: Annotated[float, Unit("rad/s")]
    """The turn rate that the person commands, positive to the left; 0 if the person is silent or does not drive."""
    commands: tuple[OperatorCommand, ...]
    """The newest command to each actuator that the person has commanded since the person took the robot."""
    time: float
    """The time of the sample on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample."""

    def format_values(self) -> str:
        """Return the velocities, or why there are none."""
        if not self.is_driving:
            return "not driving"
        if self.is_silent:
            return "silent"
        return f"{format_number(self.linear)} m/s, {format_number(self.angular)} rad/s"


class Operator(Sensor[OperatorSample]):
    """The person who drives a robot.

    >>> from robotcore.hal.kind import build_sensor
    >>> from robotcore.kinds.operator import OperatorDescription, OperatorSample
    >>> description = OperatorDescription(kind="operator", name="operator")
    >>> build_sensor(description, lambda: OperatorSample(True, False, 0.2, 0.5, (), 1.0, 0)).read()
    OperatorSample 0.20 m/s, 0.50 rad/s at 1.00 s
    """

    kind = "operator"


KIND = Kind("the person who drives the robot", OperatorDescription, Operator, OperatorSample, is_optional=True)
"""The kind `operator`, which the entry point of this name refers to."""
