"""The layer that compensates the constant errors of motors and range sensors, as the robot's file describes them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from robotcore.description import RobotDescription
from robotcore.hal.device import SampleT, Sensor
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.runtime.layers.base import Layer, MotorOutput, Reader


class CompensationLayer(Layer):
    """Commands each motor so that its wheel turns as the drive has asked, and removes the offset of range sensors.

    A measured error is the same on the robot and in a simulator, and so is its compensation. Lag, latency and noise
    cannot be compensated.
    """

    def __init__(self, description: RobotDescription) -> None:
        self._motors = {motor.name: motor for motor in description.all_of(MotorDescription) if not motor.is_exact}
        self._offsets = {sensor.name: sensor.offset_m for sensor in description.all_of(RangeSensorDescription)}

    def motor(self, motor: MotorOutput) -> MotorOutput:
        """Return an output that sends the compensated command, and returns the velocity of the wheel for it."""
        described = self._motors.get(motor.name)
        if described is None:
            return motor
        compensate, respond = described.compensate, described.respond
        return replace(motor, set_velocity=lambda rad_s: respond(motor.set_velocity(compensate(rad_s))))

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        """Return a reader of a range sensor that subtracts the described offset."""
        offset_m = self._offsets.get(sensor.name, 0.0)
        if not offset_m:
            return read

        def subtract(distance: float, _ray: Any) -> float:
            return distance - offset_m

        return lambda: sensor.change_distances(read(), subtract)
