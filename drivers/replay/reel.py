"""What the sensors of a recording gave, tick by tick."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import Generic, TypeVar, cast

from drivers.replay.clock import ReplayClock
from robotcore.errors import DeviceError, RecordingError
from robotcore.hal.devices import Angle, Frame, Range, Voltage
from robotcore.recording import Read, Recording, SampleKey

RecordedT = TypeVar("RecordedT", Range, Frame, Angle, Voltage)


class Reel(Generic[RecordedT]):
    """Gives back what one sensor gave, or raises what it raised, read by read of a tick; the last read stays.

    In a tick without a read of it, or whose sample was dropped, it gives the newest from before, which keeps its time.
    """

    def __init__(self, device: str, recording: Recording, clock: ReplayClock) -> None:
        self._device, self._samples, self._clock = device, recording.samples, clock
        self._reads = [_reads_of(device, tick.reads) for tick in recording.ticks]
        keys = ((at, read.key) for at, reads in enumerate(self._reads) for read in reads if read.key)
        self._given = [(at, key) for at, key in keys if key in self._samples]
        self._tick, self._count = -1, 0

    def __call__(self) -> RecordedT:
        """Return the sample of this read; DeviceError if there was none yet, or if it is damaged."""
        read = self._next()
        if read and read.error:
            raise read.error.again()
        key = read.key if read else None
        try:
            return cast("RecordedT", self._samples[key if key and key in self._samples else self._newest_key()])
        except RecordingError as error:
            raise DeviceError(self._device, str(error)) from error

    def _next(self) -> Read | None:
        """Return the recorded read whose turn it is in this tick, if there is one."""
        reads = self._reads[self._clock.tick]
        self._count = self._count + 1 if self._tick == self._clock.tick else 0
        self._tick = self._clock.tick
        return reads[min(self._count, len(reads) - 1)] if reads else None

    def _newest_key(self) -> SampleKey:
        at = bisect_right(self._given, self._clock.tick, key=lambda given: given[0])
        if not at:
            raise DeviceError(
                self._device, f"the recording has no sample of it by {self._clock.now():g} s: nobody had read it yet"
            )
        return self._given[at - 1][1]


def _reads_of(device: str, reads: Sequence[Read]) -> tuple[Read, ...]:
    return tuple(read for read in reads if read.device == device)
