"""The layer that lets no old sample pass."""

from __future__ import annotations

from typing import Generic

from robotcore.errors import StaleSampleError
from robotcore.hal.clock import TickClock
from robotcore.hal.devices import Battery, SampleT, Sensor, Voltage
from robotcore.runtime.layers.layer import Layer
from robotcore.runtime.layers.readers import Reader
from robotcore.safety import Latch


class Age(Layer):
    """No sensor's sample is older than ``limit`` seconds: StaleSampleError instead, which ends the run.

    A battery's may be: nobody drives by it.
    """

    def __init__(self, clock: TickClock, limit: float, latch: Latch) -> None:
        self._clock, self._limit, self._latch = clock, limit, latch

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        return Fresh(sensor.name, self._clock, self._limit, self._latch, read)

    def battery(self, battery: Battery, read: Reader[Voltage]) -> Reader[Voltage]:
        return read


class Fresh(Generic[SampleT]):
    """Reads one sensor, and trips the latch where its newest sample is too old."""

    def __init__(self, device: str, clock: TickClock, limit: float, latch: Latch, read: Reader[SampleT]) -> None:
        self._device, self._clock, self._limit, self._latch, self._read = device, clock, limit, latch, read

    def __call__(self) -> SampleT:
        sample = self._read()
        age = self._clock.now() - sample.time
        if age > self._limit:
            self._latch.trip(StaleSampleError(self._device, age, self._limit))
        return sample
