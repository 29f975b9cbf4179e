"""A motor whose velocity is a duty."""

from __future__ import annotations

from abc import ABC, abstractmethod

from robotcore.description import MotorDescription
from robotcore.hal.devices import Motor
from robotcore.hardware.motors.model import MotorModel


class Output(ABC):
    """What turns one motor: the lines to an H-bridge, or its place on a board with a protocol of its own."""

    @abstractmethod
    def turn(self, duty: float) -> None:
        """Send a duty from -1 to 1, positive forward; raises DeviceError by the motor's name."""

    @abstractmethod
    def close(self) -> None:
        """Let go of it; the motor was stopped. Raises DeviceError by the motor's name."""


class DutyMotor(Motor):
    """Sends the duty that, by the motor's model, makes the velocity asked for; each command, also one like the last."""

    def __init__(self, told: MotorDescription, model: MotorModel, output: Output) -> None:
        super().__init__(told.name, told.max_velocity_rad_s)
        self._model, self._output = model, output
        self._direction = 1

    @property
    def direction(self) -> int:
        """1 or -1: the way it was last told to turn, for a stopped wheel coasts on; 1 where it never was told to."""
        return self._direction

    def _apply(self, rad_s: float) -> None:
        self._send(rad_s)

    def _send(self, rad_s: float) -> None:
        if rad_s:
            self._direction = 1 if rad_s > 0 else -1
        self._output.turn(self._model.duty(rad_s))

    def _release(self) -> None:
        self._output.close()
