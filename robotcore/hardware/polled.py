"""Samples of devices that are polled in another thread than the app's."""

from __future__ import annotations

import math
from typing import Generic

from robotcore.description import RangeSensorDescription, RobotDescription
from robotcore.errors import DeviceError
from robotcore.hal.devices import Range, SampleT


class LatestSample(Generic[SampleT]):
    """Hands out the sample that was put in last, or raises why there is none; whichever came last.

    One thread puts, others get.

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
        """Let `get` raise, until there is a sample again."""
        if not isinstance(error, DeviceError):
            cause = error
            error = DeviceError(
                self._device, f"{type(cause).__name__}: {cause}".removesuffix(": "), kind="driver-failed"
            )
            error.__cause__ = cause
        self._last = error

    def get(self) -> SampleT:
        """Return the newest sample; raises DeviceError where the device has failed since."""
        last = self._last
        if isinstance(last, DeviceError):
            raise last
        return last


NOTHING_YET = (
    "has found nothing that could be judged; hold something flat in front of it. "
    "Where nothing is in range when it is opened, echo_free_cycles must not be 0"
)
"""What is wrong with a sensor that is open and has no sample yet."""


class RangeSampler:
    """Makes samples of a range sensor's measurements; ``newest`` has the newest sample, or the failure.

    A measurement that found nothing may have missed something: it gives no sample. A row of ``echo_free_cycles`` such
    ones vouches for nothing in range; where it is 0, none does. Times are of the robot's clock.
    """

    def __init__(self, description: RangeSensorDescription, echo_free_cycles: int) -> None:
        self.newest: LatestSample[Range] = LatestSample(
            description.name, DeviceError(description.name, NOTHING_YET, kind="no-sample-yet")
        )
        self.has_result = False
        """Whether there has been a sample, or a failure."""
        self._description, self._echo_free_cycles = description, echo_free_cycles
        self._last: Range | None = None
        self._empty = 0

    def add_distance(self, distance: float, time: float) -> None:
        """Add a distance in metres; `inf` is a target out of range."""
        self._empty = 0
        is_near = distance <= self._description.max_range_m
        self._put(max(distance, self._description.min_range_m) if is_near else math.inf, time)

    def add_no_echo(self, time: float) -> None:
        """Add a measurement without an echo."""
        self._empty += 1
        if 0 < self._echo_free_cycles <= self._empty:
            self._put(math.inf, time)

    def add_unclear(self) -> None:
        """Add a measurement that is no evidence of an echo or of none."""
        self._empty = 0

    def fail(self, error: Exception) -> None:
        """Set a failure, until the next sample."""
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
    """Raise ValueError where a sample is too old before a row of cycles has vouched for nothing in range.

    So many ``modules`` take turns.
    """
    if (takes := echo_free_cycles * cycle_s * modules) >= robot.safety.max_age_s:
        turns = f", by turns with {modules - 1} more," if modules > 1 else ""
        raise ValueError(
            f"echo_free_cycles of cycle_s{turns} take {takes:g} s, a sample may be {robot.safety.max_age_s:g} s old: "
            "with nothing in range the robot would be stopped; lower one of them, or raise safety.max_age_s"
        )
