"""The layer that compensates the errors of motors and range sensors, as the robot's file describes them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Generic

from robotcore.description import RobotDescription
from robotcore.hal.device import SampleT, Sensor
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import Range, RangeSensorDescription
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader


class CompensationLayer(Layer):
    """Commands each motor so that its wheel turns as the drive has asked, and corrects the samples of range sensors.

    A measured error is the same on the robot and in a simulator, and so is its compensation: the offset of a range
    sensor is subtracted, and its lost echoes make no sample, see `EchoHold`. Lag, latency and noise cannot be
    compensated.
    """

    def __init__(self, description: RobotDescription) -> None:
        self._motors = {motor.name: motor for motor in description.all_of(MotorDescription) if not motor.is_exact}
        self._max_age_s = description.safety.max_age_s
        self._range_sensors = {sensor.name: sensor for sensor in description.all_of(RangeSensorDescription)}

    def motor(self, motor: MotorOutput) -> MotorOutput:
        """Return an output that sends the compensated command, and returns the velocity of the wheel for it."""
        described = self._motors.get(motor.name)
        if described is None:
            return motor
        compensate, respond = described.compensate, described.respond
        return replace(motor, set_velocity=lambda rad_s: respond(motor.set_velocity(compensate(rad_s))))

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        """Return a reader of a range sensor without its described offset and its lost echoes."""
        described = self._range_sensors.get(sensor.name)
        if described is None or sensor.is_compensated:
            return read
        corrected: Reader[Any] = read
        if offset_m := described.offset_m:

            def subtract(distance: float, _ray: Any) -> float:
                # At the minimum, the body may be nearer.
                return distance - offset_m if distance > described.min_range_m else distance

            corrected = ChangedSamples(read, lambda sample: sensor.change_distances(sample, subtract))
        if described.echo_free_samples > 1:
            corrected = EchoHold(corrected, described.echo_free_samples, self._max_age_s)
        return corrected


class ChangedSamples(Generic[SampleT]):
    """Reads changed samples. A sample that is read again is the same object, so that a recording has it once."""

    def __init__(self, read: Reader[SampleT], change: Callable[[SampleT], SampleT]) -> None:
        self._read, self._change = read, change
        self._sample: SampleT | None = None
        self._changed: SampleT | None = None

    def __call__(self) -> SampleT:
        sample = self._read()
        if self._changed is None or sample != self._sample:
            self._sample, self._changed = sample, self._change(sample)
        return self._changed


class EchoHold:
    """Reads a range sensor that loses echoes. A lost echo makes no new sample.

    A sample without an echo may be a lost echo. Until enough of them follow each other, the last echo is the newest
    sample. It ends the run if it gets older than ``max_age_s``: then nothing is known about the space ahead. After a
    pause without readings, the robot stands, and the sensor begins anew without an echo.

    read: reads the sensor.
    echo_free_samples: the number of samples in a row without an echo that show that nothing is in range.
    max_age_s: the greatest age of a sample, in seconds. A longer time between two readings is a pause.

    >>> readings = [Range(0.5, 0.0, 0), Range(math.inf, 0.1, 1), Range(0.4, 0.2, 2), *(
    ...     Range(math.inf, tick / 10, tick) for tick in (3, 4, 5))]
    >>> read = EchoHold(iter(readings).__next__, echo_free_samples=2, max_age_s=1.0)
    >>> [read().distance for _ in readings]
    [0.5, 0.5, 0.4, 0.4, inf, inf]
    """

    def __init__(self, read: Reader[Range], echo_free_samples: int, max_age_s: float) -> None:
        self._read, self._echo_free_samples, self._max_age_s = read, echo_free_samples, max_age_s
        self._last: Range | None = None
        self._echo: Range | None = None
        self._missing: set[int] = set()
        """The sequence numbers of the samples without an echo after the last echo."""

    def __call__(self) -> Range:
        sample, last = self._read(), self._last
        self._last = sample
        if last and self._is_pause(last, sample):
            self._echo = None
            self._missing.clear()
        if not math.isinf(sample.distance):
            self._echo = sample
            self._missing.clear()
            return sample
        self._missing.add(sample.sequence)
        if self._echo is None or len(self._missing) >= self._echo_free_samples:
            self._echo = None
            self._missing.clear()
            return sample
        return self._echo

    def _is_pause(self, last: Range, sample: Range) -> bool:
        # The samples of a slow sensor are far apart too, but none is missing between them.
        return sample.time - last.time > self._max_age_s and sample.sequence - last.sequence > 1
