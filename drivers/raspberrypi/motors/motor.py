"""A motor whose velocity is a duty on pins."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import Protocol

from drivers.raspberrypi.claiming import pin_failure
from drivers.raspberrypi.motors.model import MotorModel, whole_percent
from robotcore.description import MotorDescription
from robotcore.devices import Motor


class Bridge(Protocol):
    """The lines of a motor board that turn one motor."""

    def turn(self, duty: float) -> None:
        """Send a duty from -1 to 1, positive forward; at 0 every line goes low, even where another one fails."""


class PinMotor(Motor):
    """Sends the duty that, by the motor's model, makes the velocity asked for.

    ``opened`` holds what is on the pins; closing lets go of each, even where another one fails.
    """

    def __init__(
        self, told: MotorDescription, model: MotorModel, bridge: Bridge, gpios: Sequence[int], opened: ExitStack
    ) -> None:
        super().__init__(told.name, told.max_velocity_rad_s)
        self._model, self._bridge, self._gpios, self._opened = model, bridge, gpios, opened
        self._direction = 1

    @property
    def direction(self) -> int:
        """1 or -1: where it was last told to turn, for a stopped wheel coasts on; 1 where it never was."""
        return self._direction

    def _apply(self, rad_s: float) -> None:
        self._send(rad_s)

    def _send(self, rad_s: float) -> None:
        if rad_s:
            self._direction = 1 if rad_s > 0 else -1
        try:
            self._bridge.turn(whole_percent(self._model.duty(rad_s)))
        except Exception as error:
            raise pin_failure(self.name, self._gpios, error) from error

    def _release(self) -> None:
        try:
            self._opened.close()
        except Exception as error:
            raise pin_failure(self.name, self._gpios, error) from error
