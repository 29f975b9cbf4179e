"""Monitors of a run: sensors that it reads by itself, the losses of devices, and the steps that wait."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf, isfinite
from typing import Any

from robotcore.errors import DeviceError, DeviceLostError
from robotcore.hal.device import Sensor, list_values
from robotcore.hal.kind import load_kind
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import read_idle_time, read_queue_time

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


class DeviceLossTracker:
    """Decides whether a run waits for lost devices, and summarises the losses.

    limit: the longest time for which a device may be lost, in seconds. With 0, each loss ends the run.
    """

    def __init__(self, limit: float) -> None:
        self.lost: list[str] = []
        """The names of the lost devices, in the order of their losses. The list is emptied when all are back."""
        self._limit = limit
        self._since = 0.0
        self._past_losses: list[tuple[str, float]] = []

    @property
    def is_enabled(self) -> bool:
        """Whether a run waits for lost devices."""
        return self._limit > 0

    def tolerate(self, lost: DeviceLostError, now: float) -> bool:
        """Record a tick in which a device was lost. Return whether the run waits for the device.

        lost: the error of the device.
        now: the time of the tick, in seconds.
        """
        if not self.is_enabled:
            return False
        if not self.lost:
            self._since = now
        if lost.device not in self.lost:
            self.lost.append(lost.device)
        return now - self._since < self._limit

    def end(self, now: float) -> None:
        """Record a tick in which no device was lost."""
        if self.lost:
            self._past_losses.append((self.lost[0], now - self._since))
            self.lost.clear()

    def summarise(self, now: float) -> tuple[str, ...]:
        """Return a sentence for each device that was lost: how many times, and how long in total."""
        names = sorted({name for name, _ in self._past_losses})
        away = f"{', '.join(self.lost)} was lost for the last {now - self._since:.1f} s. The robot stood still"
        return (*map(self._summarise_device, names), *([away] if self.lost else ()))

    def _summarise_device(self, device: str) -> str:
        lengths = [length for name, length in self._past_losses if name == device]
        often = "once" if len(lengths) == 1 else f"{len(lengths)} times"
        return f"{device} was lost {often}, for {sum(lengths):.1f} s in total. The robot stood still meanwhile"


MAX_WAIT_S = 1.0
"""The longest time that the steps of a run may wait without a note, in seconds."""

MAX_WAIT_SHARE = 1.5
"""The longest time that the steps may wait without a note, as a multiple of the simulated time."""


class WaitMonitor:
    """Measures how long the app's steps wait, as in ``time.sleep``, and reports a long time once.

    A simulation does not advance during a step. So an app that waits drives nowhere, or its run takes very long. The
    time in which the step uses the processor does not count. The time for which the thread of the run has waited for a
    busy processor is subtracted, also if it was outside the steps.

    report: a function that gets the note.
    """

    def __init__(self, report: Callable[[str], object]) -> None:
        self._report = report
        self._waited_s = self._idle_s = 0.0
        self._queue_s = read_queue_time()
        self._has_reported = False

    def begin(self) -> None:
        """Record the beginning of a step."""
        self._idle_s = read_idle_time()

    def end(self, now: float) -> None:
        """Record the end of a step.

        now: the simulated time, in seconds.
        """
        self._waited_s += read_idle_time() - self._idle_s
        limit_s = max(MAX_WAIT_S, MAX_WAIT_SHARE * now)
        if self._has_reported or self._waited_s <= limit_s:
            return
        waited_s = self._waited_s - (read_queue_time() - self._queue_s)
        if waited_s > limit_s:
            self._has_reported = True
            self._report(
                f"the app's steps have waited for {waited_s:.1f} s, and {now:.1f} s have passed in the "
                "simulation, which does not advance during a step. Do not sleep in step: return Status.RUNNING, and "
                "compare robot.clock.now() in a later tick"
            )
