"""A motor whose velocity its board holds, in whole counts."""

from __future__ import annotations

import math

from drivers.serial.boards.devices import BoardMotor, BoardOutput
from robotcore.description import MotorDescription


class CountingMotor(BoardMotor):
    """Turns by as many counts a frame as come nearest to what is asked for, and returns the velocity that they are.

    What is less than half a count a frame is no command to turn: 0 is sent, and returned. ``counts_per_rad_s`` is what
    1 rad/s is in counts a frame; ``max_velocity`` is a whole number of them.
    """

    def __init__(self, told: MotorDescription, output: BoardOutput, counts_per_rad_s: float) -> None:
        super().__init__(told, output, counts_per_rad_s)
        self._counts_per_rad_s = counts_per_rad_s
        self.max_velocity = math.floor(told.max_velocity_rad_s * counts_per_rad_s) / counts_per_rad_s

    def set_velocity(self, rad_s: float) -> float:
        return round(super().set_velocity(rad_s) * self._counts_per_rad_s) / self._counts_per_rad_s

    def _apply(self, rad_s: float) -> None:
        super()._apply(round(rad_s * self._counts_per_rad_s) / self._counts_per_rad_s)
