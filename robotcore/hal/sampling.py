"""When simulated sensors and simple drivers take their samples: at a read, or at a rate and with a latency."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from threading import Lock
from typing import Generic

from robotcore.description import DeviceDescription, SensorDescription
from robotcore.hal.clock import Clock, PeriodicTask, SteppedClock
from robotcore.hal.device import SampleT

__all__ = ["DelayedSamples", "SampleCache", "capture_at_once", "delay_samples"]


class SampleCache(Generic[SampleT]):
    """Returns the sample of the clock's present time.

    The first call at a time of the clock takes the sample. Further calls at this time return the same sample. Any
    thread may call it.

    clock: the robot's clock.
    take: takes a sample. Its arguments are the time in seconds and the sequence number, which begins at 0.

    >>> from robotcore.hal.clock import SteppedClock
    >>> from robotcore.kinds.encoder import Angle
    >>> clock = SteppedClock(20, lambda steps: None)
    >>> read = SampleCache(clock, lambda time, sequence: Angle(0.5, time, sequence))
    >>> read() is read(), clock.sleep_until(0.1), read().sequence
    (True, True, 1)
    """

    def __init__(self, clock: Clock, take: Callable[[float, int], SampleT]) -> None:
        self._clock = clock
        self._take = take
        self._sample: SampleT | None = None
        self._lock = Lock()

    def __call__(self) -> SampleT:
        with self._lock:
            now = self._clock.now()
            last = self._sample
            if last is None or last.time != now:
                self._sample = last = self._take(now, 0 if last is None else last.sequence + 1)
            return last

    def close(self) -> None:
        """Do nothing, because only a read takes a sample."""


Capture = Callable[[float, int], Callable[[], SampleT]]
"""A function that measures, and returns a function that makes the sample of the measurement.

Its arguments are the time in seconds and the sequence number, which begins at 0. The sample is made only if an app
reads it, such as a picture from the pose of a camera.
"""

REAL_TIME_HZ = 20.0
"""The number of samples in a second of a sensor without a described rate, if a simulator runs in real time."""

ROUNDING_S = 1e-6
"""A sample is available if its latency has passed up to this time, in seconds."""


class DelayedSamples(Generic[SampleT]):
    """Takes samples at a rate. Each is available after a latency, like those of a sensor with a slow interface.

    The first sample is taken and available when the sensor is opened.

    capture: measures.
    latency_s: the time from a measurement until its sample is available, in seconds.
    rate_hz: the number of samples in a second. None: in each tick, one sample becomes available. A clock in real time
        then takes `REAL_TIME_HZ` samples in a second.
    name: the name of the thread that measures in real time.

    >>> from robotcore.hal.clock import SteppedClock
    >>> clock = SteppedClock(20, lambda steps: None)
    >>> read = DelayedSamples(clock, lambda time, sequence: lambda: (time, sequence), latency_s=0.1, rate_hz=10)
    >>> [read() for _ in range(7) if clock.sleep_until(clock.now() + 0.05)]
    [(0.0, 0), (0.0, 0), (0.0, 0), (0.1, 1), (0.1, 1), (0.2, 2), (0.2, 2)]
    """

    def __init__(
        self,
        clock: Clock,
        capture: Capture[SampleT],
        latency_s: float,
        rate_hz: float | None,
        name: str = "samples",
    ) -> None:
        self._clock, self._capture, self._name, self._lock = clock, capture, name, Lock()
        self._latency, self._sequence = latency_s, 0
        self._captured: deque[tuple[float, Callable[[], SampleT]]] = deque()
        self._newest: Callable[[], SampleT] = capture(clock.now(), 0)
        self._sample: SampleT | None = None
        self._task: PeriodicTask | None = None
        self._is_closed = False
        offset = 0.0
        if isinstance(clock, SteppedClock):
            self._latency = clock.round_to_steps(latency_s)
            if rate_hz is None:
                offset = -self._latency % (1 / clock.rate_hz)
        self._period = 1 / (rate_hz or (clock.rate_hz if isinstance(clock, SteppedClock) else REAL_TIME_HZ))
        if offset:
            clock.call_at(clock.now() + offset, self._begin)
        else:
            self._repeat()

    def __call__(self) -> SampleT:
        """Return the newest available sample."""
        with self._lock:
            self._drop_old()
            if self._sample is None:
                self._sample = self._newest()
            return self._sample

    def close(self) -> None:
        """Take no more samples."""
        self._is_closed = True
        if self._task:
            self._task.stop()

    def _begin(self) -> None:
        if not self._is_closed:
            self._measure()
            self._repeat()

    def _repeat(self) -> None:
        self._task = self._clock.call_every(self._period, self._measure, self._name)

    def _measure(self) -> None:
        with self._lock:
            self._sequence += 1
            now = self._clock.now()
            self._captured.append((now, self._capture(now, self._sequence)))
            self._drop_old()

    def _drop_old(self) -> None:
        latest = self._clock.now() - self._latency + ROUNDING_S
        while self._captured and self._captured[0][0] <= latest:
            self._newest, self._sample = self._captured.popleft()[1], None


def capture_at_once(take: Callable[[float, int], SampleT]) -> Capture[SampleT]:
    """Return a function that measures and makes the sample at once, by ``take``.

    >>> from robotcore.kinds.encoder import Angle
    >>> capture = capture_at_once(lambda time, sequence: Angle(0.5, time, sequence))
    >>> capture(0.1, 1)()
    Angle 0.50 rad at 0.10 s
    """

    def capture(time: float, sequence: int) -> Callable[[], SampleT]:
        sample = take(time, sequence)
        return lambda: sample

    return capture


def delay_samples(
    clock: Clock, description: DeviceDescription, capture: Capture[SampleT]
) -> SampleCache[SampleT] | DelayedSamples[SampleT]:
    """Return a function that returns a simulated sensor's samples, with the latency and the rate of its description.

    Without both, the sample is that of the clock's present time.

    clock: the robot's clock.
    description: the description of the sensor.
    capture: measures, see `Capture`.

    >>> from robotcore.description import SensorDescription
    >>> from robotcore.hal.clock import SteppedClock
    >>> from robotcore.kinds.encoder import Angle
    >>> clock = SteppedClock(20, lambda steps: None)
    >>> late = SensorDescription(kind="encoder", name="wheel", latency_s=0.1)
    >>> read = delay_samples(clock, late, lambda time, sequence: lambda: Angle(time, time, sequence))
    >>> clock.sleep_until(0.5)
    True
    >>> round(read().time, 3)  # of the measurement
    0.4
    """
    if isinstance(description, SensorDescription) and (description.latency_s or description.rate_hz):
        return DelayedSamples(clock, capture, description.latency_s, description.rate_hz, description.name)
    return SampleCache(clock, lambda time, sequence: capture(time, sequence)())
