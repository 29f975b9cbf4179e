"""The clock and the devices of a robot that replays a recording."""

from __future__ import annotations

import heapq
import itertools
from bisect import bisect_right
from collections.abc import Sequence
from typing import Generic, TypeVar, cast

from robotcore.description import CameraDescription, RangeSensorDescription
from robotcore.errors import DeviceError, RecordingEndedError, RecordingError
from robotcore.hal.clock import Callback, Clock
from robotcore.hal.devices import (
    Angle,
    Battery,
    Camera,
    Display,
    Encoder,
    Frame,
    Image,
    Motor,
    Range,
    RangeSensor,
    Voltage,
)
from robotcore.recording import Read, Recording, SampleKey

_SAME_S = 1e-9
"""The tolerance in seconds for rounding errors in sums of periods."""


class ReplayClock(Clock):
    """A clock that advances only in a sleep, from tick to tick of a recording. ``times`` are the ticks in seconds.

    A sleep ends at the last tick before its deadline, so a loop at the recorded rate runs once in each tick. A sleep
    after the last tick raises RecordingEndedError.
    """

    def __init__(self, times: Sequence[float]) -> None:
        self._times = times
        self._now = times[0]
        self._calls: list[tuple[float, int, Callback]] = []
        self._order = itertools.count()
        self.tick = 0

    def now(self) -> float:
        return self._now

    def sleep_until(self, deadline: float) -> bool:
        is_ahead = deadline >= self._now
        self._advance()
        while self.tick + 1 < len(self._times) and self._times[self.tick + 1] <= deadline + _SAME_S:
            self._advance()
        return is_ahead

    def call_at(self, deadline: float, callback: Callback) -> None:
        heapq.heappush(self._calls, (deadline, next(self._order), callback))

    def close(self) -> None:
        self._calls.clear()

    def _advance(self) -> None:
        """Advance to the next tick, and make the calls that are due by then."""
        if self.tick + 1 == len(self._times):
            raise RecordingEndedError(len(self._times), self._now)
        self.tick += 1
        while self._calls and self._calls[0][0] <= self._times[self.tick]:
            self._now, _, callback = heapq.heappop(self._calls)
            callback()
        self._now = self._times[self.tick]


RecordedT = TypeVar("RecordedT", Range, Frame, Angle, Voltage)


class SamplePlayer(Generic[RecordedT]):
    """Returns the recorded samples of one sensor, or raises its recorded errors, in the order of the recorded reads.

    If the app reads more often in a tick than the recorded run did, the last read of the tick is repeated. If the tick
    has no recorded read, or the sample is not in the recording, it returns the newest earlier sample.
    """

    def __init__(self, device: str, recording: Recording, clock: ReplayClock) -> None:
        self._device, self._samples, self._clock = device, recording.samples, clock
        self._reads = [_list_reads(device, tick.reads) for tick in recording.ticks]
        keys = ((at, read.key) for at, reads in enumerate(self._reads) for read in reads if read.key)
        self._given = [(at, key) for at, key in keys if key in self._samples]
        self._tick, self._count = -1, 0

    def __call__(self) -> RecordedT:
        """Return the sample of the next read; raises DeviceError if there is no sample yet, or if it is damaged."""
        read = self._take_read()
        if read and read.error:
            raise read.error.rebuild()
        key = read.key if read else None
        try:
            return cast("RecordedT", self._samples[key if key and key in self._samples else self._newest_key()])
        except RecordingError as error:
            raise DeviceError(self._device, str(error), kind="recording-damaged") from error

    def _take_read(self) -> Read | None:
        """Return the next recorded read of this tick; None if the tick has no recorded read."""
        reads = self._reads[self._clock.tick]
        self._count = self._count + 1 if self._tick == self._clock.tick else 0
        self._tick = self._clock.tick
        return reads[min(self._count, len(reads) - 1)] if reads else None

    def _newest_key(self) -> SampleKey:
        at = bisect_right(self._given, self._clock.tick, key=lambda given: given[0])
        if not at:
            raise DeviceError(
                self._device,
                f"the recorded run had not read this device by {self._clock.now():g} s, so there is no sample yet",
                kind="no-sample-yet",
            )
        return self._given[at - 1][1]


def _list_reads(device: str, reads: Sequence[Read]) -> tuple[Read, ...]:
    return tuple(read for read in reads if read.device == device)


class ReplayMotor(Motor):
    """A motor that ignores its commands."""

    def _apply(self, rad_s: float) -> None:
        """Do nothing."""


class ReplayRangeSensor(RangeSensor):
    """A range sensor that returns the distances of a recording."""

    def __init__(self, description: RangeSensorDescription, player: SamplePlayer[Range]) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)
        self._player = player

    def _newest(self) -> Range:
        return self._player()


class ReplayCamera(Camera):
    """A camera that returns the pictures of a recording."""

    def __init__(self, description: CameraDescription, player: SamplePlayer[Frame]) -> None:
        super().__init__(description.name, description.intrinsics)
        self._player = player

    def _newest(self) -> Frame:
        return self._player()


class ReplayEncoder(Encoder):
    """An encoder that returns the angles of a recording."""

    def __init__(self, name: str, player: SamplePlayer[Angle]) -> None:
        super().__init__(name)
        self._player = player

    def _newest(self) -> Angle:
        return self._player()


class ReplayBattery(Battery):
    """A battery that returns the voltages of a recording."""

    def __init__(self, name: str, player: SamplePlayer[Voltage]) -> None:
        super().__init__(name)
        self._player = player

    def _newest(self) -> Voltage:
        return self._player()


class ReplayDisplay(Display):
    """A display that shows nothing, and raises the errors of the recorded display."""

    def __init__(self, name: str, recording: Recording, clock: ReplayClock) -> None:
        super().__init__(name)
        self._clock, self._tick, self._count = clock, -1, 0
        self._shown = [[each.error for each in tick.shown if each.device == name] for tick in recording.ticks]

    def _show(self, image: Image) -> None:
        tick = self._clock.tick
        self._count = self._count + 1 if self._tick == tick else 0
        self._tick = tick
        if (errors := self._shown[tick][self._count : self._count + 1]) and errors[0]:
            raise errors[0].rebuild()
