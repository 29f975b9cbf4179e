"""The sensors that a run reads by itself, such as a battery."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite
from typing import Any

from robotcore.errors import DeviceError
from robotcore.hal.device import Sensor, list_values
from robotcore.hal.kind import load_kind
from robotcore.hal.robot import Robot

PERIOD_S = 1.0
"""The time between two readings of a monitored sensor, in seconds of the robot's clock."""

PROBLEM_S = 3.0
"""A problem that lasts for this time, in seconds, causes a warning.

A motor that starts lowers the voltage of a battery too, but for a shorter time.
"""


class SensorMonitor:
    """Reads every monitored sensor of a robot, such as a battery, once a second, even if the app reads none.

    The values are recorded, and problems cause warnings. They do not stop the run.
    """

    def __init__(self, robot: Robot) -> None:
        devices = robot.devices.values()
        self._gauges = [Gauge(device) for device in devices if isinstance(device, Sensor) and device.is_monitored]
        self._due = -inf if self._gauges else inf
        self.values: Mapping[str, float] = {}
        """The last value of each sensor, by name. Each reading replaces the mapping."""

    def read(self, now: float) -> tuple[str, ...]:
        """Read the sensors if `PERIOD_S` has passed since the last reading. Return new warnings, each a sentence.

        now: the robot's time, in seconds.
        """
        if now < self._due:
            return ()
        self._due = now + PERIOD_S
        warnings = [gauge.read() for gauge in self._gauges]
        self.values = {gauge.name: gauge.value for gauge in self._gauges if gauge.value is not None}
        return tuple(filter(None, warnings))


class Gauge:
    """Reads one sensor. It warns once in a run about a problem, and once about each series of failed reads."""

    def __init__(self, sensor: Sensor[Any]) -> None:
        self.name = sensor.name
        self.value: float | None = None
        """The first number of the newest sample; None before the first sample."""
        self._sensor = sensor
        self._field, self._unit = list_values(load_kind(sensor.kind).sample)[0]
        self._good_at = -inf
        self._has_failed = self._has_warned = False

    def read(self) -> str:
        """Read the sensor. Return a warning, or an empty text."""
        try:
            sample = self._sensor.read()
        except DeviceError as failure:
            return self._build_failure_warning(str(failure))
        value = getattr(sample, self._field)
        if not isfinite(value):
            problem = f"{self.name}: the {self._field} is {value} {self._unit}. Report this to the author of the driver"
            return self._build_failure_warning(problem)
        self.value = value
        return self._build_problem_warning(sample)

    def _build_failure_warning(self, why: str) -> str:
        has_failed, self._has_failed = self._has_failed, True
        return "" if has_failed else f"{why.rstrip('.')}. The run continues without this sensor"

    def _build_problem_warning(self, sample: Any) -> str:
        # At the start of a run the warning has no delay, because no motor lowers a voltage yet.
        problem = self._sensor.find_problem(sample)
        if not problem:
            self._good_at = sample.time
        elif not self._has_warned and sample.time - self._good_at >= PROBLEM_S:
            self._has_warned = True
            return f"{self.name}: {problem}"
        return ""
