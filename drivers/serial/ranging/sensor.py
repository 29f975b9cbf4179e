"""The range sensors on a serial line."""

from __future__ import annotations

from drivers.serial.line import Line
from robotcore.hardware import PolledRangeSensor
from robotcore.hardware.polled_samples import NOTHING_YET, RangeSampler
from robotcore.kinds.range_sensor import Range, RangeSensorDescription


class LineRangeSensor(PolledRangeSensor):
    """A range sensor on a serial line. Reading it raises DeviceLostError while the line is lost."""

    def __init__(self, description: RangeSensorDescription, sampler: RangeSampler, line: Line, first_s: float) -> None:
        """Create the sensor. ``first_s`` is the longest wait for the first sample, in seconds."""
        super().__init__(description, sampler)
        self._line, self._first_s = line, first_s

    def _start(self) -> None:
        self._line.wait_until(lambda: self._sampler.has_result, self.name, self._first_s, lambda: NOTHING_YET)
        self._newest()

    def _newest(self) -> Range:
        self._line.require(self.name)
        newest = super()._newest()
        self._line.require_since_lost(self.name, newest.time)
        return newest
