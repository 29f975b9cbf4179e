"""Faults in the values of samples, such as noise, stuck distances and slip. The times of capture do not change."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field

from robotcore.hal.devices import Angle, Image, Range, RangeSensor, Sensor
from robotcore.runtime.faults.base import Fault, FaultContext, PollingLayer, Probability, TargetKind
from robotcore.runtime.layers.base import Layer, Reader, limit_reading
from robotcore.runtime.layers.imperfections import ProcessedFrames, build_noise_effect

Deviation = Annotated[float, Field(gt=0, le=1, description="metres")]
Distance = Annotated[float, Field(gt=0, le=100, description="metres")]


class RangeFault(Fault):
    """The base class of faults that change the readings of a range sensor."""

    on = frozenset({TargetKind.RANGE})

    @abstractmethod
    def distort(self, context: FaultContext, sensor: RangeSensor, reading: Range) -> Range:
        """Return the changed reading."""

    def layer(self, context: FaultContext) -> RangeDistortion:
        return RangeDistortion(self, context)


class RangeNoise(RangeFault):
    """Distances have normal noise with the given standard deviation."""

    example = "range noise=0.05"

    value: Deviation

    def distort(self, context: FaultContext, sensor: RangeSensor, reading: Range) -> Range:
        error = context.noise(sensor.name, self.value).draw_number(reading.time)
        return limit_reading(sensor, reading, reading.distance + error)


class Stuck(RangeFault):
    """A range sensor always returns the given distance. The times of capture advance as without the fault.

    A distance beyond the sensor's range becomes ``inf``.
    """

    example = "range stuck=1.5 after=5"

    value: Distance

    def distort(self, context: FaultContext, sensor: RangeSensor, reading: Range) -> Range:
        return limit_reading(sensor, replace(reading, point=None), self.value)


class Spikes(RangeFault):
    """Distances become random distances within the sensor's range, each with the given probability."""

    example = "range spikes=0.1"

    value: Probability

    def distort(self, context: FaultContext, sensor: RangeSensor, reading: Range) -> Range:
        random = context.random_at(sensor.name, reading.time)
        if random.random() >= self.value:
            return reading
        distance = random.uniform(sensor.min_range, sensor.max_range)
        return limit_reading(sensor, replace(reading, point=None), distance)


class RangeDistortion(Layer):
    """Changes each reading of a range sensor while ``fault`` is active."""

    def __init__(self, fault: RangeFault, context: FaultContext) -> None:
        self._fault, self._context = fault, context

    def sensor(self, sensor: Any, read: Reader[Any]) -> Reader[Any]:
        def distorted() -> Range:
            reading: Range = read()
            is_on = self._fault.is_on(reading.time)
            return self._fault.distort(self._context, sensor, reading) if is_on else reading

        return distorted


GreyLevels = Annotated[float, Field(gt=0, le=64, description="grey levels")]


class CameraNoise(Fault):
    """Pixels have normal noise with the given standard deviation."""

    on = frozenset({TargetKind.CAMERA})
    example = "camera noise=20 after=5"

    value: GreyLevels

    def layer(self, context: FaultContext) -> NoisyPictures:
        return NoisyPictures(self, context)


class NoisyPictures(Layer):
    """Adds noise to the pictures that are captured while ``fault`` is active."""

    def __init__(self, fault: CameraNoise, context: FaultContext) -> None:
        self._fault, self._context = fault, context

    def sensor(self, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        noisy = build_noise_effect(self._context.noise(sensor.name, self._fault.value))

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
        return SlipLayer(self)


class SlipLayer(PollingLayer):
    """Subtracts a share of each rotation between two samples if ``fault`` was active at the first of them."""

    def __init__(self, fault: Slip) -> None:
        super().__init__()
        self._fault = fault

    def sensor(self, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        last, missed = Angle(0.0, 0.0, 0), 0.0

        def slipping() -> Angle:
            nonlocal last, missed
            sample: Angle = read()
            if self._fault.is_on(last.time):
                missed += self._fault.value * (sample.angle - last.angle)
            last = sample
            return replace(sample, angle=sample.angle - missed)

        return self.poll(slipping)
