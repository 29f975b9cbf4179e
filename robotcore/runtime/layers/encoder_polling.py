"""Reads the encoders of the drive between two ticks, so that the odometry follows wheels that accelerate in a tick."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from robotcore.description import Drive
from robotcore.geometry import Wheels
from robotcore.hal.clock import Clock, ClockWrapper, PeriodicTask
from robotcore.hal.device import Device, SampleT, Sensor
from robotcore.kinds.encoder import Angle, Encoder
from robotcore.runtime.layers.base import Layer, Reader

MAX_POINTS = 512
"""The number of polls that are stored between two readings of the odometry: those of 2.5 s at 200 Hz."""

ROUNDING = 1e-6
"""A sleep that is longer than a period by less than this share of it is no reason for a further poll."""


class TimedAngles(NamedTuple):
    """The angles of the two wheels at a time."""

    time: float
    """The time in seconds."""
    angles: Wheels
    """The angles in radians."""


class EncoderPolling(Layer):
    """Reads the encoders of the drive at a fixed rate, and stores their mean angles of each side.

    It is the layer next to the driver, so no fault, recording or check gets the polls. It also stores the samples of
    the encoders that each tick reads through it. A poll that fails is left out, because the read of the tick raises
    the error of a failed encoder.

    In simulated time, the polls divide the sleep between two ticks, so that each poll follows all other calls of its
    time, such as those of a model that moves an encoder. In real time, a thread polls from `begin` to `end`.

    left, right: the driver's encoders of each side.
    clock: the driver's clock.
    rate_hz: the number of polls in a second.
    """

    def __init__(self, left: Sequence[Encoder], right: Sequence[Encoder], clock: Clock, rate_hz: float) -> None:
        self._left, self._right, self._clock, self._rate_hz = left, right, clock, rate_hz
        self._points: deque[TimedAngles] = deque(maxlen=MAX_POINTS)
        self._polled_at = -math.inf
        self._read: dict[str, Any] = {}
        self._task: PeriodicTask | None = None

    def begin(self) -> None:
        """Start the thread of a clock that is not in lockstep. Raises ResourceError if the system refuses it."""
        if not self._clock.is_lockstep:
            self._task = self._clock.call_every(1 / self._rate_hz, self._poll, "encoder polling")

    def end(self) -> None:
        """End the thread before the encoders are closed. A second `end` does nothing."""
        if self._task:
            self._task.stop()

    def sensor(self, sensor: Sensor[SampleT], read: Reader[SampleT]) -> Reader[SampleT]:
        if not (isinstance(sensor, Encoder) and sensor in (*self._left, *self._right)):
            return read
        samples, name = self._read, sensor.name

        def read_stored() -> SampleT:
            samples[name] = sample = read()
            return sample

        return read_stored

    def clock(self, clock: Clock) -> Clock:
        return _DividedSleep(clock, self) if clock.is_lockstep else clock

    def sleep_until(self, source: Clock, deadline: float) -> bool:
        """Sleep on a clock in lockstep until a time in seconds, and poll at the set rate before that time."""
        start = source.now()
        parts = math.ceil((deadline - start) * self._rate_hz - ROUNDING)
        for part in range(1, parts):
            source.sleep_until(start + (deadline - start) * part / parts)
            self._poll()
        return source.sleep_until(deadline)

    def list_read(self) -> tuple[Sequence[Angle], Sequence[Angle]] | None:
        """Return the last samples of the encoders of each side that were read through this layer. None if one lacks."""
        samples = self._read
        try:
            return [samples[each.name] for each in self._left], [samples[each.name] for each in self._right]
        except KeyError:  # a fault may return samples of its own
            return None

    def take(self, since: float, until: float) -> Sequence[TimedAngles]:
        """Remove the polls before ``until``, and return those of them after ``since``. Both are times in seconds."""
        points, taken = self._points, []
        while points and points[0].time < until:
            point = points.popleft()  # of a full queue, the thread may have removed the one that was the oldest
            if since < point.time < until:
                taken.append(point)
        return taken

    def _poll(self) -> None:
        try:
            left, right = [each.read() for each in self._left], [each.read() for each in self._right]
            times = [each.time for each in (*left, *right)]
            if min(times) > self._polled_at:  # a repeated sample of one encoder would not fit the others
                self._polled_at = max(times)
                self._points.append(TimedAngles(self._polled_at, compute_mean_angles(left, right)))
        except Exception:  # noqa: BLE001, S110  the tick's own read raises the error
            pass


class _DividedSleep(ClockWrapper):
    def __init__(self, source: Clock, polling: EncoderPolling) -> None:
        super().__init__(source)
        self._polling = polling

    def sleep_until(self, deadline: float) -> bool:
        return self._polling.sleep_until(self._source, deadline)


def compute_mean_angles(left: Sequence[Angle], right: Sequence[Angle]) -> Wheels:
    """Return the mean angles of the samples of each side, in radians."""
    return Wheels(sum(each.angle for each in left) / len(left), sum(each.angle for each in right) / len(right))


def build_polling(
    devices: Mapping[str, Device], drive: Drive | None, clock: Clock, encoder_rate_hz: float | None, rate_hz: float
) -> EncoderPolling | None:
    """Return the polling of the drive's encoders. None without encoders on both sides, or for ticks that are as fast.

    devices: the driver's devices.
    encoder_rate_hz: the number of polls in a second; None for no polls.
    rate_hz: the number of ticks in a second.
    """
    if drive is None or encoder_rate_hz is None or encoder_rate_hz <= rate_hz:
        return None
    left, right = find_encoders(devices, drive.left_encoders), find_encoders(devices, drive.right_encoders)
    return EncoderPolling(left, right, clock, encoder_rate_hz) if left and right else None


def find_encoders(devices: Mapping[str, Device], names: Sequence[str]) -> list[Encoder]:
    """Return the open encoders with these names."""
    return [device for device in map(devices.get, names) if isinstance(device, Encoder)]
