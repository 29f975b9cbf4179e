"""The clock and the devices of a robot that replays a recording."""

from __future__ import annotations

import heapq
import itertools
from bisect import bisect_right
from collections.abc import Iterator, Sequence

from robotcore.errors import DeviceError, InvalidCommandError, RecordingEndedError, RecordingError
from robotcore.hal.clock import Callback, Clock
from robotcore.hal.device import Sample
from robotcore.kinds.motor import Motor
from robotcore.recording import Read, RecordedError, Recording, SampleKey
from robotcore.recording.events import ActuatorCommand, ShownPicture

_SAME_S = 1e-9
"""The tolerance for equal times, in seconds. Sums of periods have rounding errors."""


class ReplayClock(Clock):
    """A clock that has the times of the recorded ticks. It advances only in a sleep, by at least one tick.

    A sleep ends at the last tick that is not after its deadline. After the last tick of the recording, a sleep raises
    RecordingEndedError.

    times: the times of the ticks, in seconds.
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
        if self.tick + 1 == len(self._times):
            raise RecordingEndedError(len(self._times), self._now)
        self.tick += 1
        while self._calls and self._calls[0][0] <= self._times[self.tick]:
            self._now, _, callback = heapq.heappop(self._calls)
            callback()
        self._now = self._times[self.tick]


class ReplayReader:
    """Repeats the recorded reads of a sensor: a call returns their samples or raises their errors.

    After the last recorded read of a tick, this read is repeated. If a tick has no recorded read, or its sample was not
    recorded, the newest earlier sample is returned.
    """

    def __init__(self, recording: Recording, clock: ReplayClock, name: str) -> None:
        self._name, self._samples, self._clock = name, recording.samples, clock
        self._reads = [[read for read in tick.reads if read.device == name] for tick in recording.ticks]
        keys = ((at, read.key) for at, reads in enumerate(self._reads) for read in reads if read.key)
        self._given = [(at, key) for at, key in keys if key in self._samples]
        self._tick, self._count = -1, 0

    def __call__(self) -> Sample:
        read = self._take_read()
        if read and read.error:
            raise read.error.rebuild()
        key = read.key if read else None
        try:
            return self._samples[key if key and key in self._samples else self._newest_key()]
        except RecordingError as error:
            raise DeviceError(self._name, str(error), kind="recording-damaged") from error

    def _take_read(self) -> Read | None:
        reads = self._reads[self._clock.tick]
        self._count = self._count + 1 if self._tick == self._clock.tick else 0
        self._tick = self._clock.tick
        return reads[min(self._count, len(reads) - 1)] if reads else None

    def _newest_key(self) -> SampleKey:
        at = bisect_right(self._given, self._clock.tick, key=lambda given: given[0])
        if not at:
            raise DeviceError(
                self._name,
                f"the recording has no sample of this device at {self._clock.now():g} s or before",
                kind="no-sample-yet",
            )
        return self._given[at - 1][1]


class ReplayMotor(Motor):
    """A motor that ignores its commands."""

    def _apply(self, rad_s: float) -> None:
        """Do nothing."""


class ReplaySender:
    """Ignores the commands to an actuator, and raises its recorded errors."""

    def __init__(self, recording: Recording, clock: ReplayClock, name: str) -> None:
        self._clock, self._tick = clock, -1
        self._sent: Iterator[RecordedError | None] = iter(())
        commands: list[list[ShownPicture | ActuatorCommand]] = [
            [*tick.shown, *tick.commands] for tick in recording.ticks
        ]
        self._errors = [[each.error for each in sent if each.device == name] for sent in commands]

    def __call__(self, command: object) -> None:
        if self._tick != self._clock.tick:
            self._tick = self._clock.tick
            self._sent = iter(self._errors[self._tick])
        error = next(self._sent, None)
        if error and error.kind != InvalidCommandError.__name__:  # the device itself refuses an invalid command again
            raise error.rebuild()
