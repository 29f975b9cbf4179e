"""Motors that are driven by a duty: the model that converts a velocity to a duty, and the motor that uses it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Annotated

from pydantic import Field, PositiveFloat

from robotcore.description import MotorDescription, StrictModel
from robotcore.hal.devices import Motor

FullSpeed = Annotated[PositiveFloat, Field(description="the wheel's velocity at full duty in rad/s, such as 14.0")]


class MotorModel(StrictModel):
    """The velocity of a wheel at each duty. It is zero up to the dead band, and linear above.

    Measure the velocities while the wheel turns in the air, supplied by the robot's own battery.

    >>> model = MotorModel(dead_band=0.5, forward_rad_s=16.0, backward_rad_s=8.0)
    >>> model.duty(8.0), model.duty(-4.0), model.duty(0.0)
    (0.75, -0.75, 0.0)
    >>> model.velocity(0.75)
    8.0
    """

    dead_band: Annotated[float, Field(ge=0, lt=1)] = 0.0
    """The greatest duty, from 0 to 1, at which the wheel still stands."""
    forward_rad_s: FullSpeed
    """The velocity of the wheel at the duty 1, in rad/s."""
    backward_rad_s: FullSpeed
    """The velocity of the wheel at the duty -1, in rad/s, as a positive number."""
    max_duty: Annotated[float, Field(gt=0, le=1)] = 1.0
    """The greatest duty that is sent. Lower it if the motor's rated voltage is below the battery's."""

    def duty(self, rad_s: float) -> float:
        """Return the duty from -1 to 1 for a velocity, limited to ``max_duty``."""
        if rad_s == 0:
            return 0.0
        above = abs(rad_s) * (1 - self.dead_band) / self._full_rad_s(rad_s)
        return math.copysign(min(self.dead_band + above, self.max_duty), rad_s)

    def velocity(self, duty: float) -> float:
        """Return the velocity in rad/s at a duty from -1 to 1, which may be greater than ``max_duty``."""
        above = max(0.0, abs(duty) - self.dead_band)
        return math.copysign(above / (1 - self.dead_band) * self._full_rad_s(duty), duty) if above else 0.0

    def reach(self, direction: float) -> float:
        """Return the greatest velocity in one direction in rad/s, as a positive number.

        direction: a positive number for forward, a negative one for backward.
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
    """The output of duties to one motor: the pins of an H-bridge, or one side of a board on a serial line."""

    @abstractmethod
    def turn(self, duty: float) -> None:
        """Send a duty from -1 to 1, positive forward; raises DeviceError with the motor's name."""

    @abstractmethod
    def close(self) -> None:
        """Release the output of a stopped motor; raises DeviceError with the motor's name."""


class DutyMotor(Motor):
    """A motor that sends each command as a duty, which the motor's model gives. An equal command is sent again."""

    def __init__(self, description: MotorDescription, model: MotorModel, output: Output) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._model, self._output = model, output
        self._direction = 1

    @property
    def direction(self) -> int:
        """The direction of the newest command that was not a stop: 1 forward, -1 backward; 1 before the first command.

        A wheel coasts in this direction after a stop.
        """
        return self._direction

    def _apply(self, rad_s: float) -> None:
        self._send(rad_s)

    def _send(self, rad_s: float) -> None:
        if rad_s:
            self._direction = 1 if rad_s > 0 else -1
        self._output.turn(self._model.duty(rad_s))

    def _release(self) -> None:
        self._output.close()
