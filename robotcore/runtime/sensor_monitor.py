"""The sensors that a run reads by itself, such as a battery."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf, isfinite
from typing import Any

from robotcore.errors import DeviceError
from robotcore.hal.device import Sample, Sensor, build_driver_error, list_values
from robotcore.hal.robot import Robot
from robotcore.runtime.trace import MonitoredValue

PERIOD_S = 1.0
"""The time between two readings of a monitored sensor, in seconds of the robot's clock."""

PROBLEM_S = 3.0
"""A problem that lasts for this time, in seconds, causes a warning.

A motor that starts lowers the voltage of a battery too, but for a shorter time.
"""


def find_number(sample: Sample) -> MonitoredValue | None:
    """Return the first field of a sample that is a number; None if there is none."""
    values = ((getattr(sample, field), unit) for field, unit in list_values(type(sample)))
    return next((MonitoredValue(value, unit) for value, unit in values if isinstance(value, (float, int))), None)


class SensorMonitor:
    """Reads every monitored sensor of a robot, such as a battery, once a second, even if the app reads none.

    The values are recorded, and problems cause warnings. They do not stop the run.
    """

    def __init__(self, robot: Robot) -> None:
        devices = robot.devices.values()
        self._gauges = [Gauge(device) for device in devices if isinstance(device, Sensor) and device.is_monitored]
        self._due = -inf if self._gauges else inf
        self.values: Mapping[str, MonitoredValue] = {}
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
        self.value: MonitoredValue | None = None
        """The first number of the newest sample; None before the first sample, and if samples have no number."""
        self._sensor = sensor
        self._good_at = -inf
        self._has_failed = self._has_warned = False

    def read(self) -> str:
        """Read the sensor. Return a warning, or an empty text."""
        try:
            sample = self._sensor.read()
        except DeviceError as failure:
            return self._build_failure_warning(str(failure))
        value = find_number(sample)
        if value and not isfinite(value.value):
            text = self._sensor.format_sample(sample)
            return self._build_failure_warning(f"{self.name} returned {text}. Report this to the author of the driver")
        self.value = value
        return self._build_problem_warning(sample)

    def _build_failure_warning(self, why: str) -> str:
        has_failed, self._has_failed = self._has_failed, True
        return "" if has_failed else f"{why.rstrip('.')}. The run continues without this sensor"

    def _build_problem_warning(self, sample: Any) -> str:
        # At the start of a run the warning has no delay, because no motor lowers a voltage yet.
        try:
            problem = self._sensor.find_problem(sample)
        except Exception as error:  # noqa: BLE001  the sensor may be of another package
            return self._build_failure_warning(str(build_driver_error(self.name, error)))
        if not problem:
            self._good_at = sample.time
        elif not self._has_warned and sample.time - self._good_at >= PROBLEM_S:
            self._has_warned = True
            return f"{self.name}: {problem}"
        return ""
