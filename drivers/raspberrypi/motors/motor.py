"""A motor whose velocity is a duty on pins."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import ExitStack

from drivers.raspberrypi.claiming import claiming, pin_failure
from drivers.raspberrypi.motors.model import MotorModel, whole_percent
from robotcore.description import MotorDescription
from robotcore.devices import Motor


class Bridge(ABC):
    """The lines to a motor board that turn one motor: these GPIOs, and how to let go of them."""

    def __init__(self, gpios: Sequence[int], opened: ExitStack) -> None:
        self.gpios, self._opened = gpios, opened

    @abstractmethod
    def turn(self, duty: float) -> None:
        """Send a duty from -1 to 1, positive forward; at 0 no line's failure keeps another one from going low."""

    def close(self) -> None:
        """Let go of each line, even where another one fails."""
        self._opened.close()


class PinMotor(Motor):
    """Sends the duty that, by the motor's model, makes the velocity asked for; each command, also one like the last."""

    def __init__(self, told: MotorDescription, model: MotorModel, bridge: Bridge) -> None:
        super().__init__(told.name, told.max_velocity_rad_s)
        self._model, self._bridge = model, bridge
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
        try:
            self._bridge.turn(whole_percent(self._model.duty(rad_s)))
        except Exception as error:
            raise pin_failure(self.name, self._bridge.gpios, error) from error

    def _release(self) -> None:
        with claiming(self.name, self._bridge.gpios):
            self._bridge.close()
