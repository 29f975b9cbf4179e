"""Stores the newest samples of devices that a background thread reads."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable
from contextlib import ExitStack
from typing import Generic

from robotcore.description import RobotDescription
from robotcore.errors import DeviceError
from robotcore.hal.device import SampleT, build_driver_error
from robotcore.kinds.range_sensor import Range, RangeSensor, RangeSensorDescription


class NewestSample(Generic[SampleT]):
    """Stores the newest sample of a device, or the failure of the device after that sample.

    A background thread calls `put` and `fail`, and other threads call `get`.

    device: the name of the device, for errors.
    first: the first sample, or the error that `get` raises before the first sample.

    >>> from robotcore.kinds.range_sensor import Range
    >>> newest = NewestSample("nose", Range(0.5, time=0.0, sequence=0))
    >>> newest.fail(OSError("unplugged"))
    >>> newest.put(Range(0.4, time=0.2, sequence=1))
    >>> newest.get().distance
    0.4
    """

    def __init__(self, device: str, first: SampleT | DeviceError) -> None:
        self._device = device
        self._last: SampleT | DeviceError = first

    def put(self, sample: SampleT) -> None:
        """Store a sample. It replaces the last sample or failure."""
        self._last = sample

    def fail(self, error: Exception) -> None:
        """Store a failure, which `get` raises until the next sample.

        An error of another class becomes the ``__cause__`` of a DeviceError.
        """
        if not isinstance(error, DeviceError):
            cause = error
            error = build_driver_error(self._device, cause, "driver-failed")
            error.__cause__ = cause
        self._last = error

    def get(self) -> SampleT:
        """Return the newest sample. Raises DeviceError if the device has failed after this sample."""
        last = self._last
        if isinstance(last, DeviceError):
            raise last
        return last


NOTHING_YET = (
    "has no measurement with an echo yet. Hold something flat in front of it. "
    "If nothing is in range when the sensor is opened, echo_free_cycles must not be 0"
)
"""The problem in the error of a range sensor without a sample."""


class RangeSampler:
    """Converts the measurements of a range sensor to samples, and stores the newest sample in ``newest``.

    A single measurement without an echo may be an error, so it makes no sample. Several in a row make a sample with the
    distance ``inf``, which means that nothing is in range.

    >>> from robotcore.description import load_robot
    >>> from robotcore.kinds.range_sensor import RangeSensorDescription
    >>> (nose,) = load_robot("rover").all_of(RangeSensorDescription)
    >>> sampler = RangeSampler(nose, echo_free_cycles=2)
    >>> sampler.add_distance(0.5, time=0.0)
    >>> sampler.add_no_echo(time=0.1)
    >>> sampler.newest.get().distance
    0.5
    >>> sampler.add_no_echo(time=0.2)
    >>> sampler.newest.get().distance
    inf
    """

    def __init__(self, description: RangeSensorDescription, echo_free_cycles: int) -> None:
        """Create a sampler without a sample.

        echo_free_cycles: the number of measurements in a row without an echo that make a sample of ``inf``. With 0,
            measurements without an echo never make a sample.
        """
        self.newest: NewestSample[Range] = NewestSample(
            description.name, DeviceError(description.name, NOTHING_YET, kind="no-sample-yet")
        )
        self.has_result = False
        """Whether there has been a sample or a failure."""
        self._description, self._echo_free_cycles = description, echo_free_cycles
        self._last: Range | None = None
        self._empty = 0

    def add_distance(self, distance: float, time: float) -> None:
        """Add a measured distance in metres; ``inf`` if nothing is in range.

        time: the time of the measurement on the robot's clock, in seconds.
        """
        self._empty = 0
        is_near = distance <= self._description.max_range_m
        self._put(max(distance, self._description.min_range_m) if is_near else math.inf, time)

    def add_no_echo(self, time: float) -> None:
        """Add a measurement without an echo.

        time: the time of the measurement on the robot's clock, in seconds.
        """
        self._empty += 1
        if 0 < self._echo_free_cycles <= self._empty:
            self._put(math.inf, time)

    def add_unclear(self) -> None:
        """Add a failed measurement, from which it is unknown whether there was an echo."""
        self._empty = 0

    def fail(self, error: Exception) -> None:
        """Store a failure, which reading raises until the next sample."""
        self._empty = 0
        self.has_result = True
        self.newest.fail(error)

    def clear_failure(self) -> None:
        """Remove the stored failure. The last sample is the newest one again, with its old time."""
        if self._last:
            self.newest.put(self._last)

    def _put(self, distance: float, time: float) -> None:
        self._last = Range(distance, time, self._last.sequence + 1 if self._last else 0)
        self.has_result = True
        self.newest.put(self._last)


class PolledRangeSensor(RangeSensor):
    """A range sensor that returns the newest sample of a `RangeSampler`.

    A subclass starts its hardware in `_start`, and registers in ``_opened`` what stops the hardware.

    description: the description of the sensor.
    sampler: converts the measurements to samples.

    >>> from robotcore.description import load_robot
    >>> from robotcore.hardware import RangeSampler
    >>> class Sonar(PolledRangeSensor):
    ...     def _start(self):
    ...         self._opened.callback(print, "the hardware has stopped")
    ...         self._take_first(lambda: self._sampler.add_distance(0.5, time=0.1), wait=lambda: None, cycles=3)
    >>> nose = load_robot("rover").first_of("range_sensor")
    >>> sonar = Sonar(nose, RangeSampler(nose, echo_free_cycles=2))
    >>> sonar.open()
    >>> sonar.read()
    Range 0.50 m at 0.10 s
    >>> sonar.close()
    the hardware has stopped
    """

    def __init__(self, description: RangeSensorDescription, sampler: RangeSampler) -> None:
        super().__init__(
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._sampler, self._opened = sampler, ExitStack()

    def open(self) -> None:
        """Start measuring, and wait for the first sample; closes the sensor and raises DeviceError if there is none."""
        try:
            self._start()
        except BaseException:
            self.close()
            raise

    @abstractmethod
    def _start(self) -> None:
        """Start measuring, and wait for the first sample; raises DeviceError."""

    def _take_first(self, measure: Callable[[], object], wait: Callable[[], object], cycles: int) -> None:
        """Measure up to ``cycles`` times until there is a result; raises DeviceError if it is not a sample."""
        for _ in range(cycles):
            measure()
            wait()
            if self._sampler.has_result:
                break
        self._newest()

    def _release(self) -> None:
        self._opened.close()

    def _newest(self) -> Range:
        return self._sampler.newest.get()


def require_timely(echo_free_cycles: int, cycle_s: float, robot: RobotDescription, modules: int = 1) -> None:
    """Raise ValueError if the sample of ``inf`` would come too late, so that the robot would stop in free space.

    It comes after ``echo_free_cycles`` measurements. Until then, the last sample must not exceed safety.max_age_s.

    cycle_s: the period of a module's measurements in seconds.
    modules: the number of modules that measure in turn.
    """
    if (duration := echo_free_cycles * cycle_s * modules) >= robot.safety.max_age_s:
        factor = f" times {modules} modules in turn" if modules > 1 else ""
        raise ValueError(
            f"echo_free_cycles times cycle_s{factor} is {duration:g} s, which is not below safety.max_age_s, "
            f"{robot.safety.max_age_s:g} s, so the robot would stop if nothing is in range; reduce echo_free_cycles or "
            "cycle_s, or raise safety.max_age_s"
        )
