"""What a layer over a device owes whoever stops or closes it."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from robotcore.hal.devices import Motor, Range, RangeSensor


class MotorOver(Motor):
    """A motor seen through a layer; what it is told goes as a subclass has it, a stop goes straight to the motor."""

    def __init__(self, inner: Motor) -> None:
        super().__init__(inner.name, inner.max_velocity)
        self._inner = inner

    def stop(self) -> None:
        if not self._is_closed:
            self._inner.stop()

    def _release(self) -> None:
        self._inner.close()


def reading_of(sensor: RangeSensor, reading: Range, distance: float) -> Range:
    """Return a reading at another distance: never nearer than the sensor can tell, and ``inf`` past its range."""
    if distance > sensor.max_range:
        return replace(reading, distance=inf, point=None)
    return replace(reading, distance=max(distance, sensor.min_range))
