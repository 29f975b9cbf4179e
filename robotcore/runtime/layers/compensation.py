"""The layer that compensates the errors of motors and range sensors, as the robot's file describes them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from robotcore.description import RobotDescription
from robotcore.hal.device import SampleT, Sensor
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import Range, RangeSensorDescription
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader

MAX_AGE_SHARE = 0.5
"""The age up to which an echo is repeated, as a share of ``max_age_s``. An older sample would end the run."""


class CompensationLayer(Layer):
    """Commands each motor so that its wheel turns as the drive has asked, and corrects the samples of range sensors.

    A measured error is the same on the robot and in a simulator, and so is its compensation: the offset of a range
    sensor is subtracted, and its lost echoes make no sample, see `EchoHold`. Lag, latency and noise cannot be
    compensated.
    """

    def __init__(self, description: RobotDescription) -> None:
        self._motors = {motor.name: motor for motor in description.all_of(MotorDescription) if not motor.is_exact}
        self._range_sensors = {sensor.name: sensor for sensor in description.all_of(RangeSensorDescription)}
        self._max_age_s = MAX_AGE_SHARE * description.safety.max_age_s

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
                return distance - offset_m

            def read_without_offset() -> SampleT:
                return sensor.change_distances(read(), subtract)

            corrected = read_without_offset
        if described.echo_free_samples > 1:
            corrected = EchoHold(corrected, described.echo_free_samples, self._max_age_s - described.latency_s)
        return corrected


class EchoHold:
    """Reads a range sensor that loses echoes. A lost echo makes no new sample.

    A sample without an echo may be a lost echo. Until enough of them follow each other, the last echo is the newest
    sample.

    read: reads the sensor.
    echo_free_samples: the number of samples in a row without an echo that show that nothing is in range.
    limit_s: the longest time in seconds from an echo to a sample in place of which it is returned.

    >>> readings = [Range(0.5, 0.0, 0), Range(math.inf, 0.1, 1), Range(0.4, 0.2, 2), *(
    ...     Range(math.inf, tick / 10, tick) for tick in (3, 4, 5))]
    >>> read = EchoHold(iter(readings).__next__, echo_free_samples=2, limit_s=0.5)
    >>> [read().distance for _ in readings]
    [0.5, 0.5, 0.4, 0.4, inf, inf]
    """

    def __init__(self, read: Reader[Range], echo_free_samples: int, limit_s: float) -> None:
        self._read, self._echo_free_samples, self._limit_s = read, echo_free_samples, limit_s
        self._echo: Range | None = None
        self._missing: set[int] = set()
        """The sequence numbers of the samples without an echo after the last echo."""

    def __call__(self) -> Range:
        sample = self._read()
        if not math.isinf(sample.distance):
            self._echo = sample
            self._missing.clear()
            return sample
        self._missing.add(sample.sequence)
        if self._echo is None or self._is_sure(sample, self._echo):
            self._echo = None
            self._missing.clear()
            return sample
        return self._echo

    def _is_sure(self, sample: Range, echo: Range) -> bool:
        return len(self._missing) >= self._echo_free_samples or sample.time - echo.time > self._limit_s
