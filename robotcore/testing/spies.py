"""Spies: they look at, or break, the hook by which a motor's driver is told its velocity."""

from __future__ import annotations

import math

from robotcore.errors import DeviceError
from robotcore.hal.devices import Motor


class MotorSpy:
    """Keeps what reaches a motor's hardware, in rad/s, and lets it through."""

    def __init__(self, motor: Motor) -> None:
        self.sent: list[float] = []
        self._apply = motor._apply  # noqa: SLF001  the hook that every driver fills in
        setattr(motor, "_apply", self._note)  # noqa: B010  on this one motor, not on its class

    @property
    def last(self) -> float:
        """What was sent last; NaN where nothing was."""
        return self.sent[-1] if self.sent else math.nan

    def _note(self, rad_s: float) -> None:
        self.sent.append(rad_s)
        self._apply(rad_s)


def cut_wire(motor: Motor) -> None:
    """From now on, let every command to this motor fail."""

    def fail(_rad_s: float) -> None:
        raise DeviceError(motor.name, "the kit has cut its wire")

    setattr(motor, "_apply", fail)  # noqa: B010  on this one motor, not on its class
