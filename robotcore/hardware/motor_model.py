"""Motors of boards that take a duty instead of a velocity: the model of a motor, and the motor that uses it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Annotated

from pydantic import Field, PositiveFloat

from robotcore.description import MotorDescription, StrictModel
from robotcore.hal.devices import Motor

FullSpeed = Annotated[PositiveFloat, Field(description="the wheel's velocity at full duty in rad/s, such as 14.0")]


class MotorModel(StrictModel):
    """The velocity of a wheel by duty: zero up to the dead band, and linear above it.

    Measure the velocities with the wheel in the air, with the battery of the robot.

    >>> model = MotorModel(dead_band=0.5, forward_rad_s=16.0, backward_rad_s=8.0)
    >>> model.duty(8.0), model.duty(-4.0), model.duty(0.0)
    (0.75, -0.75, 0.0)
    >>> model.velocity(0.75)
    8.0
    """

    dead_band: Annotated[float, Field(ge=0, lt=1)] = 0.0
    """The greatest duty at which the wheel stands."""
    forward_rad_s: FullSpeed
    """The velocity at full duty forward."""
    backward_rad_s: FullSpeed
    """The velocity at full duty backward, without its sign."""
    max_duty: Annotated[float, Field(gt=0, le=1)] = 1.0
    """The greatest duty that is sent, for a motor with a lower voltage than the battery."""

    def duty(self, rad_s: float) -> float:
        """Return the duty from -1 to 1 for a velocity, limited to ``max_duty``."""
        if rad_s == 0:
            return 0.0
        above = abs(rad_s) * (1 - self.dead_band) / self._full_rad_s(rad_s)
        return math.copysign(min(self.dead_band + above, self.max_duty), rad_s)

    def velocity(self, duty: float) -> float:
        """Return the velocity in rad/s at a duty, which may be greater than ``max_duty``."""
        above = max(0.0, abs(duty) - self.dead_band)
        return math.copysign(above / (1 - self.dead_band) * self._full_rad_s(duty), duty) if above else 0.0

    def reach(self, direction: float) -> float:
        """Return the greatest velocity in rad/s, without its sign.

        direction: positive for forward, negative for backward.
        """
        return abs(self.velocity(math.copysign(self.max_duty, direction)))

    def _full_rad_s(self, direction: float) -> float:
        return self.forward_rad_s if direction > 0 else self.backward_rad_s


Model = Annotated[
    MotorModel,
    Field(
        description="a table such as { dead_band = 0.1, forward_rad_s = 14.0, backward_rad_s = 14.0 }; "
        "docs/raspberry-pi.md says how to measure it"
    ),
]
"""A motor's model in a robot's file."""


class Output(ABC):
    """The output to one motor: the pins of an H-bridge, or one side of a board with a protocol."""

    @abstractmethod
    def turn(self, duty: float) -> None:
        """Send a duty from -1 to 1, positive forward; raises DeviceError with the motor's name."""

    @abstractmethod
    def close(self) -> None:
        """Release the output of a stopped motor; raises DeviceError with the motor's name."""


class DutyMotor(Motor):
    """Sends each command as a duty, by the motor's model; equal commands are sent again."""

    def __init__(self, description: MotorDescription, model: MotorModel, output: Output) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._model, self._output = model, output
        self._direction = 1

    @property
    def direction(self) -> int:
        """The direction of the last command that was not 0, 1 or -1, for a stopped wheel coasts on; 1 before it."""
        return self._direction

    def _apply(self, rad_s: float) -> None:
        self._send(rad_s)

    def _send(self, rad_s: float) -> None:
        if rad_s:
            self._direction = 1 if rad_s > 0 else -1
        self._output.turn(self._model.duty(rad_s))

    def _release(self) -> None:
        self._output.close()
