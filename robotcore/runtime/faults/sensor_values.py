"""Faults in the values of samples, such as noise, stuck distances and slip. The times of capture do not change."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field

from robotcore.hal.devices import Angle, Image, Range, RangeSensor, Sensor
from robotcore.runtime.faults.base import Fault, FaultContext, PollingLayer, Probability, TargetKind
from robotcore.runtime.layers.base import Layer, Reader, limit_reading
from robotcore.runtime.layers.imperfections import ProcessedFrames, build_noise_effect

Deviation = Annotated[float, Field(gt=0, le=1, description="metres")]
Distance = Annotated[float, Field(gt=0, le=100, description="metres")]


class RangeNoise(Fault):
    """Distances have normal noise with the given standard deviation."""

    on = frozenset({TargetKind.RANGE})
    example = "range noise=0.05"

    value: Deviation

    def layer(self, context: FaultContext) -> RangeDistortion:
        def noisy(sensor: RangeSensor, reading: Range) -> Range:
            error = context.noise(sensor.name, self.value).draw_number(reading.time)
            return limit_reading(sensor, reading, reading.distance + error)

        return RangeDistortion(self, noisy)


class Stuck(Fault):
    """A range sensor always returns the given distance. The times of capture advance as without the fault.

    A distance beyond the sensor's range becomes ``inf``.
    """

    on = frozenset({TargetKind.RANGE})
    example = "range stuck=1.5 after=5"

    value: Distance

    def layer(self, context: FaultContext) -> RangeDistortion:
        return RangeDistortion(self, lambda sensor, reading: _replace_distance(sensor, reading, self.value))


class Spikes(Fault):
    """Distances become random distances within the sensor's range, each with the given probability."""

    on = frozenset({TargetKind.RANGE})
    example = "range spikes=0.1"

    value: Probability

    def layer(self, context: FaultContext) -> RangeDistortion:
        def spiky(sensor: RangeSensor, reading: Range) -> Range:
            random = context.random_at(sensor.name, reading.time)
            if random.random() >= self.value:
                return reading
            return _replace_distance(sensor, reading, random.uniform(sensor.min_range, sensor.max_range))

        return RangeDistortion(self, spiky)


class RangeDistortion(Layer):
    """Replaces each reading of a range sensor by the result of ``misread`` while ``fault`` is active."""

    def __init__(self, fault: Fault, misread: Callable[[RangeSensor, Range], Range]) -> None:
        self._fault, self._misread = fault, misread

    def sensor(self, sensor: Any, read: Reader[Any]) -> Reader[Any]:
        def misread() -> Range:
            reading: Range = read()
            return self._misread(sensor, reading) if self._fault.is_on(reading.time) else reading

        return misread


def _replace_distance(sensor: RangeSensor, reading: Range, distance: float) -> Range:
    return limit_reading(sensor, replace(reading, point=None), distance)


GreyLevels = Annotated[float, Field(gt=0, le=64, description="grey levels")]


class CameraNoise(Fault):
    """Pixels have normal noise with the given standard deviation."""

    on = frozenset({TargetKind.CAMERA})
    example = "camera noise=20 after=5"

    value: GreyLevels

    def layer(self, context: FaultContext) -> NoisyPictures:
        return NoisyPictures(self, self.value, context)


class NoisyPictures(Layer):
    """Adds noise to the pictures that are captured while ``fault`` is active."""

    def __init__(self, fault: Fault, sigma: float, context: FaultContext) -> None:
        self._fault, self._sigma, self._context = fault, sigma, context

    def sensor(self, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        noisy = build_noise_effect(self._context.noise(sensor.name, self._sigma))

        def effect(image: Image, time: float) -> Image:
            return noisy(image, time) if self._fault.is_on(time) else image

        return ProcessedFrames(read, [effect])


Share = Annotated[float, Field(ge=0, le=1, description="share")]


class Slip(Fault):
    """An encoder does not measure the given share of its wheel's rotation."""

    on = frozenset({TargetKind.ENCODER})
    example = "encoders slip=0.1"

    value: Share

    def layer(self, context: FaultContext) -> SlipLayer:
        return SlipLayer(self, self.value)


class SlipLayer(PollingLayer):
    """Subtracts a ``share`` of each wheel's rotation from its encoder's angle while ``fault`` is active."""

    def __init__(self, fault: Fault, share: float) -> None:
        super().__init__()
        self._fault, self._share = fault, share

    def sensor(self, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        return self.poll(_SlippingEncoder(read, self._fault, self._share))


class _SlippingEncoder:
    """Subtracts a share of each rotation between two samples if the fault was active at the first of them."""

    def __init__(self, read: Reader[Angle], fault: Fault, share: float) -> None:
        self._read, self._fault, self._share = read, fault, share
        self._last = Angle(0.0, 0.0, 0)
        self._missed = 0.0

    def __call__(self) -> Angle:
        sample, last = self._read(), self._last
        if self._fault.is_on(last.time):
            self._missed += self._share * (sample.angle - last.angle)
        self._last = sample
        return replace(sample, angle=sample.angle - self._missed)
