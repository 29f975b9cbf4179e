"""Distances that are not those in front of the sensor; time and number are those of true readings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated

from pydantic import Field

from robotcore.hal.devices import Range, RangeSensor
from robotcore.runtime.faults.fault import Fault, Kind, Probability
from robotcore.runtime.faults.occasion import Occasion
from robotcore.runtime.layers.layer import Layer
from robotcore.runtime.layers.over import reading_of
from robotcore.runtime.layers.readers import Reader

Deviation = Annotated[float, Field(gt=0, le=1, description="metres")]
Distance = Annotated[float, Field(gt=0, le=100, description="metres")]


class RangeNoise(Fault):
    """Adds normal noise of this deviation to each distance."""

    on = frozenset({Kind.RANGE})
    example = "range noise=0.05"

    value: Deviation

    def layer(self, occasion: Occasion) -> Misreading:
        def noisy(sensor: RangeSensor, reading: Range) -> Range:
            error = occasion.noise(sensor.name, self.value).at(reading.time)
            return reading_of(sensor, reading, reading.distance + error)

        return Misreading(self, noisy)


class Stuck(Fault):
    """Always tells this distance, as if it were new; past its range, that nothing is there."""

    on = frozenset({Kind.RANGE})
    example = "range stuck=1.5 after=5"

    value: Distance

    def layer(self, occasion: Occasion) -> Misreading:
        return Misreading(self, lambda sensor, reading: _elsewhere(sensor, reading, self.value))


class Spikes(Fault):
    """Tells, with this probability, a distance drawn anywhere within its range."""

    on = frozenset({Kind.RANGE})
    example = "range spikes=0.1"

    value: Probability

    def layer(self, occasion: Occasion) -> Misreading:
        def spiky(sensor: RangeSensor, reading: Range) -> Range:
            random = occasion.random_at(sensor.name, reading.time)
            if random.random() >= self.value:
                return reading
            return _elsewhere(sensor, reading, random.uniform(sensor.min_range, sensor.max_range))

        return Misreading(self, spiky)


class Misreading(Layer):
    """Makes of each reading of a range sensor another one while ``fault`` is there."""

    def __init__(self, fault: Fault, misread: Callable[[RangeSensor, Range], Range]) -> None:
        self._fault, self._misread = fault, misread

    def range_sensor(self, sensor: RangeSensor, read: Reader[Range]) -> Reader[Range]:
        def misread() -> Range:
            reading = read()
            return self._misread(sensor, reading) if self._fault.is_on(reading.time) else reading

        return misread


def _elsewhere(sensor: RangeSensor, reading: Range, distance: float) -> Range:
    return reading_of(sensor, replace(reading, point=None), distance)
