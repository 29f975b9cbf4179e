"""A sensor that measures the distance ahead of the robot, at the place where it was at the time of each sample."""

from __future__ import annotations

import math
from typing import Any

from robotcore.description import RobotDescription
from robotcore.errors import RobotcoreError
from robotcore.hal.device import Sample, Sensor, build_driver_error
from robotcore.hal.joint import Joints

STRAIGHT_RAD = math.pi / 6
"""A sensor looks straight ahead if it also looks ahead after a turn by this angle, in radians, to each side."""


class SensorAhead:
    """A sensor that looks ahead, or that a servo may turn ahead.

    joints: the assumed motion of the servos.
    """

    def __init__(self, device: Sensor[Any], robot: RobotDescription, joints: Joints) -> None:
        self.device = device
        self._body, self._mount, self._joints = robot.body, robot.mounts[device.name], joints
        (self._does_look_ahead,) = (each.looks_ahead for each in robot.sensors_ahead if each.name == device.name)
        self.is_fixed = self._mount.on is None
        self._sample: Sample | None = None
        self._distance = math.inf

    def looks_ahead(self, time: float) -> bool:
        """Return whether the sensor looks ahead at a time in seconds."""
        return self.is_fixed or self._does_look_ahead(self._joints.locate(self._mount, time))

    def looks_straight_ahead(self, time: float) -> bool:
        """Return whether the sensor looks ahead at a time in seconds, also after a turn by `STRAIGHT_RAD`."""
        mount = self._joints.locate(self._mount, time)
        return all(self._does_look_ahead(mount.face(mount.yaw_rad + each)) for each in (-STRAIGHT_RAD, STRAIGHT_RAD))

    def measure(self, sample: Sample) -> float:
        """Return the free distance ahead in a sample, in metres. The sensor must have looked ahead at its time.

        Raises DeviceError if the sensor's class fails.
        """
        if sample is not self._sample:
            mount = self._mount if self.is_fixed else self._joints.locate(self._mount, sample.time)
            try:
                self._distance = float(self.device.measure_ahead(sample, mount, self._body))
            except RobotcoreError:
                raise
            except Exception as error:
                raise build_driver_error(self.device.name, error) from error
            self._sample = sample
        return self._distance
