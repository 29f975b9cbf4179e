"""The model that converts a motor's velocity to a duty, and the motors that use the model."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Annotated

from pydantic import Field, PositiveFloat

from robotcore.description import StrictModel
from robotcore.kinds.motor import Motor, MotorDescription

FullSpeed = Annotated[PositiveFloat, Field(description="the wheel's velocity at full duty in rad/s, such as 14.0")]


class MotorModel(StrictModel):
    """The relation between a motor's duty and the wheel's velocity: zero in the dead band, and linear above it.

    Measure the velocities while the wheel turns in the air and the robot's own battery supplies the motor.

    >>> model = MotorModel(dead_band=0.5, forward_rad_s=16.0, backward_rad_s=8.0)
    >>> model.duty(8.0), model.duty(-4.0), model.duty(0.0)
    (0.75, -0.75, 0.0)
    >>> model.velocity(0.75)
    8.0
    """

    dead_band: Annotated[float, Field(ge=0, lt=1)] = 0.0
    """The greatest duty, from 0 to 1, at which the wheel does not turn."""
    forward_rad_s: FullSpeed
    """The velocity of the wheel at the duty 1, in rad/s."""
    backward_rad_s: FullSpeed
    """The velocity of the wheel at the duty -1, in rad/s, as a positive number."""
    max_duty: Annotated[float, Field(gt=0, le=1)] = 1.0
    """The greatest duty that is sent. Reduce it if the motor's rated voltage is below the battery's voltage."""

    def duty(self, rad_s: float) -> float:
        """Return the duty, from -1 to 1, for a velocity in rad/s. The duty is limited to ``max_duty``."""
        if rad_s == 0:
            return 0.0
        above = abs(rad_s) * (1 - self.dead_band) / self._full_rad_s(rad_s)
        return math.copysign(min(self.dead_band + above, self.max_duty), rad_s)

    def velocity(self, duty: float) -> float:
        """Return the velocity in rad/s at a duty from -1 to 1. The duty may exceed ``max_duty``."""
        above = max(0.0, abs(duty) - self.dead_band)
        return math.copysign(above / (1 - self.dead_band) * self._full_rad_s(duty), duty) if above else 0.0

    def reach(self, direction: float) -> float:
        """Return the greatest velocity in one direction, in rad/s, as a positive number.

        direction: a positive number for forward, a negative number for backward.
        """
        return abs(self.velocity(math.copysign(self.max_duty, direction)))

    def _full_rad_s(self, direction: float) -> float:
        return self.forward_rad_s if direction > 0 else self.backward_rad_s


Model = Annotated[
    MotorModel,
    Field(
        description="a table such as { dead_band = 0.1, forward_rad_s = 14.0, backward_rad_s = 14.0 }; "
        'the page "From a box of parts to a robot" of the documentation says how to measure it'
    ),
]
"""The type of a key ``model`` in a robot's file."""


class Output(ABC):
    """Sends duties to one motor, for example by the pins of an H-bridge or by a board on a serial port."""

    @abstractmethod
    def turn(self, duty: float) -> None:
        """Send a duty from -1 to 1, positive forward. Raises DeviceError if the hardware fails."""

    @abstractmethod
    def close(self) -> None:
        """Release the hardware after the motor was stopped. Raises DeviceError if the hardware fails."""


class OutputMotor(Motor):
    """A motor that sends each command to an `Output`, also one that equals the last one.

    Without a model, the output takes velocities in rad/s in place of duties.
    """

    def __init__(self, description: MotorDescription, output: Output) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._output = output

    def _apply(self, rad_s: float) -> None:
        self._output.turn(rad_s)

    def _release(self) -> None:
        self._output.close()


class DutyMotor(OutputMotor):
    """A motor that converts each command to a duty by the motor's model, and sends the duty to an `Output`."""

    def __init__(self, description: MotorDescription, model: MotorModel, output: Output) -> None:
        super().__init__(description, output)
        self._model, self._direction = model, 1

    @property
    def direction(self) -> int:
        """The direction in which the wheel turns, or coasts after a stop: 1 forward, -1 backward.

        It is that of the newest command other than a stop, and 1 before the first command.
        """
        return self._direction

    def _apply(self, rad_s: float) -> None:
        self._send(rad_s)

    def _send(self, rad_s: float) -> None:
        if rad_s:
            self._direction = 1 if rad_s > 0 else -1
        self._output.turn(self._model.duty(rad_s))
