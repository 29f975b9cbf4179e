"""The newest sample of a device that is polled beside the app."""

from __future__ import annotations

from typing import Generic

from robotcore.errors import DeviceError
from robotcore.hal.devices import SampleT


class Newest(Generic[SampleT]):
    """Hands out the sample that was put in last, or raises why there is none; whichever came last.

    One thread puts, others get.

    >>> from robotcore.hal.devices import Range
    >>> newest = Newest("nose", Range(0.5, time=0.0, sequence=0))
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
            error = DeviceError(self._device, f"{type(cause).__name__}: {cause}".removesuffix(": "))
            error.__cause__ = cause
        self._last = error

    def get(self) -> SampleT:
        """Return the newest sample; raises DeviceError where the device has failed since."""
        last = self._last
        if isinstance(last, DeviceError):
            raise last
        return last
