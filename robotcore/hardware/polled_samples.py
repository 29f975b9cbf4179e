"""Samples of devices that another thread than the app's polls."""

from __future__ import annotations

import math
from typing import Generic

from robotcore.description import RangeSensorDescription, RobotDescription
from robotcore.errors import DeviceError
from robotcore.hal.devices import Range, SampleT


class LatestSample(Generic[SampleT]):
    """The newest sample of a device, or its failure if that is newer. One thread puts, others get.

    >>> from robotcore.hal.devices import Range
    >>> newest = LatestSample("nose", Range(0.5, time=0.0, sequence=0))
    >>> newest.fail(OSError("unplugged"))
    >>> newest.put(Range(0.4, time=0.2, sequence=1))
    >>> newest.get().distance
    0.4
    """

    def __init__(self, device: str, first: SampleT | DeviceError) -> None:
        self._device = device
        self._last: SampleT | DeviceError = first

    def put(self, sample: SampleT) -> None:
        """Replace the last sample or failure."""
        self._last = sample

    def fail(self, error: Exception) -> None:
        """Let `get` raise until the next sample. Another error than a DeviceError becomes the cause of one."""
        if not isinstance(error, DeviceError):
            cause = error
            error = DeviceError(
                self._device, f"{type(cause).__name__}: {cause}".removesuffix(": "), kind="driver-failed"
            )
            error.__cause__ = cause
        self._last = error

    def get(self) -> SampleT:
        """Return the newest sample; raises DeviceError if the device has failed since."""
        last = self._last
        if isinstance(last, DeviceError):
            raise last
        return last


NOTHING_YET = (
    "has no measurement with an echo yet. Hold something flat in front of it. "
    "If nothing is in range when it is opened, echo_free_cycles must not be 0"
)
"""The fault of an open sensor without a sample."""


class RangeSampler:
    """Makes samples of the measurements of a range sensor.

    A measurement without an echo may have missed the target, so it makes no sample. Several of them in a row mean that
    nothing is in range.

    >>> from robotcore.description import load_robot
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
        """Start without a sample.

        echo_free_cycles: so many measurements in a row without an echo mean that nothing is in range; if it is 0, they
            never do.
        """
        self.newest: LatestSample[Range] = LatestSample(
            description.name, DeviceError(description.name, NOTHING_YET, kind="no-sample-yet")
        )
        self.has_result = False
        """Whether there has been a sample or a failure."""
        self._description, self._echo_free_cycles = description, echo_free_cycles
        self._last: Range | None = None
        self._empty = 0

    def add_distance(self, distance: float, time: float) -> None:
        """Add a distance in metres, `inf` for a target out of range.

        time: of the measurement, on the robot's clock in seconds.
        """
        self._empty = 0
        is_near = distance <= self._description.max_range_m
        self._put(max(distance, self._description.min_range_m) if is_near else math.inf, time)

    def add_no_echo(self, time: float) -> None:
        """Add a measurement without an echo."""
        self._empty += 1
        if 0 < self._echo_free_cycles <= self._empty:
            self._put(math.inf, time)

    def add_unclear(self) -> None:
        """Add a measurement that shows neither an echo nor the absence of one."""
        self._empty = 0

    def fail(self, error: Exception) -> None:
        """Set a failure that lasts until the next sample."""
        self._empty = 0
        self.has_result = True
        self.newest.fail(error)

    def clear_failure(self) -> None:
        """Clear the failure; the last good sample becomes current, with its old timestamp."""
        if self._last:
            self.newest.put(self._last)

    def _put(self, distance: float, time: float) -> None:
        self._last = Range(distance, time, self._last.sequence + 1 if self._last else 0)
        self.has_result = True
        self.newest.put(self._last)


def require_timely(echo_free_cycles: int, cycle_s: float, robot: RobotDescription, modules: int = 1) -> None:
    """Raise ValueError if a sample becomes too old before a row of cycles shows that nothing is in range.

    cycle_s: the period of measuring in seconds.
    modules: the number of modules that take turns.
    """
    if (takes := echo_free_cycles * cycle_s * modules) >= robot.safety.max_age_s:
        turns = f", in turns with {modules - 1} more," if modules > 1 else ""
        raise ValueError(
            f"echo_free_cycles times cycle_s{turns} is {takes:g} s, but a sample may be only "
            f"{robot.safety.max_age_s:g} s old, so the robot would stop with nothing in range; lower one of them, or "
            "raise safety.max_age_s"
        )
