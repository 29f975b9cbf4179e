"""Devices that are more on this board than on others: velocities in whole counts, ranges that may be in doubt."""

from __future__ import annotations

import math

from drivers.serial.boards.devices import BoardMotor, BoardOutput, BoardSensor
from drivers.serial.ports.line import Line
from robotcore.description import MotorDescription, RangeSensorDescription
from robotcore.hal.devices import Range, RangeSensor
from robotcore.hardware.findings import Findings


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


class Sonar(BoardSensor[Range], RangeSensor):
    """Tells what the board's module has found; where the line is lost, nothing."""

    def __init__(self, told: RangeSensorDescription, line: Line, findings: Findings) -> None:
        RangeSensor.__init__(
            self, told.name, min_range=told.min_range_m, max_range=told.max_range_m, cone=told.cone_rad
        )
        self._line, self._findings = line, findings

    def await_first(self, within_s: float) -> None:
        self._line.wait_until(lambda: self._findings.has_told, self.name, within_s, self._untold)
        self._newest()

    def _newest(self) -> Range:
        self._line.require(self.name)
        newest = self._findings.newest.get()
        self._line.require_since_lost(self.name, newest.time)
        return newest
