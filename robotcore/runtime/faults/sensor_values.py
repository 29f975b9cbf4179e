"""Faults in the values of samples, such as noise, stuck distances and slip. The times of capture do not change."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field

from robotcore.hal.device import Sensor
from robotcore.hal.noise import build_noise_effect
from robotcore.kinds.camera import Camera
from robotcore.kinds.encoder import Angle, Encoder
from robotcore.kinds.range_sensor import Range, RangeSensor
from robotcore.optics import Image
from robotcore.runtime.faults.base import FaultContext, Probability, SensorFault
from robotcore.runtime.layers.base import Reader
from robotcore.runtime.layers.imperfections import ProcessedFrames

StandardDeviation = Annotated[float, Field(gt=0, le=1, description="metres")]
Offset = Annotated[float, Field(ge=-100, le=100, description="metres")]
Distance = Annotated[float, Field(gt=0, le=100, description="metres")]
GreyLevels = Annotated[float, Field(gt=0, le=64, description="grey levels")]
Fraction = Annotated[float, Field(ge=0, le=1, description="share")]


class RangeFault(SensorFault):
    """The base class of faults that change the readings of a range sensor."""

    target_classes = (RangeSensor,)

    @abstractmethod
    def distort(self, context: FaultContext, sensor: RangeSensor, reading: Range) -> Range:
        """Return the changed reading. It is then limited to the sensor's range."""

    def change(self, context: FaultContext, sensor: Any, read: Reader[Any]) -> Reader[Any]:
        def read_distorted() -> Any:
            reading: Range = read()
            if not self.is_active(reading.time):
                return reading
            return sensor.limit_sample(self.distort(context, sensor, reading))

        return read_distorted


class RangeNoise(RangeFault):
    """Distances have normal noise with the given standard deviation."""

    example = "range noise=0.05"

    value: StandardDeviation

    def distort(self, context: FaultContext, sensor: RangeSensor, reading: Range) -> Range:
        error = context.noise(sensor.name, self.value).draw_number(reading.time)
        return replace(reading, distance=reading.distance + error)


class RangeBias(RangeFault):
    """The given distance is added to each distance."""

    example = "range bias=0.1"

    value: Offset

    def distort(self, context: FaultContext, sensor: RangeSensor, reading: Range) -> Range:
        return replace(reading, distance=reading.distance + self.value)


class StuckRange(RangeFault):
    """A range sensor always returns the given distance. The times of capture advance as without the fault.

    A distance beyond the sensor's range becomes ``inf``.
    """

    example = "range stuck=1.5 after=5"

    value: Distance

    def distort(self, context: FaultContext, sensor: RangeSensor, reading: Range) -> Range:
        return replace(reading, distance=self.value, point=None)


class RangeSpikes(RangeFault):
    """Distances become random distances within the sensor's range, each with the given probability."""

    example = "range spikes=0.1"

    value: Probability

    def distort(self, context: FaultContext, sensor: RangeSensor, reading: Range) -> Range:
        random = context.random_at(sensor.name, reading.time)
        if random.random() >= self.value:
            return reading
        return replace(reading, distance=random.uniform(sensor.min_range, sensor.max_range), point=None)


class CameraNoise(SensorFault):
    """Pixels have normal noise with the given standard deviation."""

    target_classes = (Camera,)
    example = "camera noise=20 after=5"

    value: GreyLevels

    def change(self, context: FaultContext, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        add_noise = build_noise_effect(context.noise(sensor.name, self.value))

        def add_noise_during_the_fault(image: Image, time: float) -> Image:
            return add_noise(image, time) if self.is_active(time) else image

        return ProcessedFrames(read, [add_noise_during_the_fault])


class Slip(SensorFault):
    """An encoder does not measure the given share of its wheel's rotation.

    The share is subtracted from each rotation between two samples if the fault was active at the first of them.
    """

    target_classes = (Encoder,)
    example = "encoders slip=0.1"
    is_polling = True

    value: Fraction

    def change(self, context: FaultContext, sensor: Sensor[Any], read: Reader[Any]) -> Reader[Any]:
        last, missed = Angle(0.0, 0.0, 0), 0.0

        def read_slipping() -> Angle:
            nonlocal last, missed
            sample: Angle = read()
            if self.is_active(last.time):
                missed += self.value * (sample.angle - last.angle)
            last = sample
            return replace(sample, angle=sample.angle - missed)

        return read_slipping
