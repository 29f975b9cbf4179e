"""Faults of readings: noise, spikes and stuck distances, noisy pictures. Time and number of a sample stay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated

from pydantic import Field

from robotcore.hal.devices import Camera, Frame, Image, Range, RangeSensor
from robotcore.runtime.faults.base import Fault, Kind, Occasion, Probability
from robotcore.runtime.layers.base import Layer, Reader, reading_of
from robotcore.runtime.layers.imperfections import Developed, grain

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


GreyLevels = Annotated[float, Field(gt=0, le=64, description="grey levels")]


class CameraNoise(Fault):
    """Adds normal noise of this deviation to each pixel."""

    on = frozenset({Kind.CAMERA})
    example = "camera noise=20 after=5"

    value: GreyLevels

    def layer(self, occasion: Occasion) -> Grainy:
        return Grainy(self, self.value, occasion)


class Grainy(Layer):
    """Adds noise to the pictures that are captured while ``fault`` is there."""

    def __init__(self, fault: Fault, sigma: float, occasion: Occasion) -> None:
        self._fault, self._sigma, self._occasion = fault, sigma, occasion

    def camera(self, camera: Camera, read: Reader[Frame]) -> Reader[Frame]:
        grainy = grain(self._occasion.noise(camera.name, self._sigma))

        def effect(image: Image, time: float) -> Image:
            return grainy(image, time) if self._fault.is_on(time) else image

        return Developed(read, [effect])
