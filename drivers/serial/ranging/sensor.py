"""The range sensors on a serial line."""

from __future__ import annotations

from drivers.serial.line import Line
from robotcore.description import RangeSensorDescription
from robotcore.hal.devices import Range
from robotcore.hardware import SampledRangeSensor
from robotcore.hardware.polled_samples import NOTHING_YET, RangeSampler


class LineRangeSensor(SampledRangeSensor):
    """A range sensor on a serial line. Reading it raises DeviceLostError while the line is lost."""

    def __init__(self, description: RangeSensorDescription, sampler: RangeSampler, line: Line) -> None:
        super().__init__(description, sampler)
        self._line = line

    def await_first(self, within_s: float) -> None:
        """Wait up to ``within_s`` seconds for the first sample; raises DeviceError if there is none."""
        self._line.wait_until(lambda: self._sampler.has_result, self.name, within_s, lambda: NOTHING_YET)
        self._newest()

    def _newest(self) -> Range:
        self._line.require(self.name)
        newest = super()._newest()
        self._line.require_since_lost(self.name, newest.time)
        return newest
