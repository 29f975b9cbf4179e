"""A sensor that measures the distance ahead of the robot, at the place where it was at the time of each sample."""

from __future__ import annotations

import math
from typing import Any

from robotcore.description import RobotDescription
from robotcore.hal.device import Sample, Sensor
from robotcore.hal.joint import Joints


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

    def measure(self, sample: Sample) -> float:
        """Return the free distance ahead in a sample, in metres; ``inf`` if the sensor looked aside at its time."""
        if sample is not self._sample:
            mount = self._mount if self.is_fixed else self._joints.locate(self._mount, sample.time)
            is_ahead = self.is_fixed or self._does_look_ahead(mount)
            self._sample = sample
            self._distance = self.device.measure_ahead(sample, mount, self._body) if is_ahead else math.inf
        return self._distance
