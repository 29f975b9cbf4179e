"""Simulated sensors, which take a sample when the app reads them, at most one at each simulated time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, NamedTuple

from robotcore.hal.clock import Clock
from robotcore.hal.device import SampleT
from robotcore.kinds.camera import Camera, Frame
from robotcore.kinds.encoder import Angle, Encoder, EncoderDescription
from robotcore.kinds.range_sensor import Range, RangeSensor, RangeSensorDescription
from robotcore.optics import Image, Intrinsics


class SampleCache(Generic[SampleT]):
    """Returns the sample of the present simulated time.

    The first call at a simulated time takes the sample. Further calls at this time return the same sample.

    clock: the simulated clock.
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

    def __call__(self) -> SampleT:
        now = self._clock.now()
        last = self._sample
        if last is None or last.time != now:
            self._sample = last = self._take(now, 0 if last is None else last.sequence + 1)
        return last


class SampledEncoder(Encoder):
    """An encoder of a simulated wheel, which measures in whole counts.

    read_angle: returns the angle of the wheel in radians.
    """

    def __init__(self, description: EncoderDescription, clock: Clock, read_angle: Callable[[], float]) -> None:
        super().__init__(description.name)

        def take(time: float, sequence: int) -> Angle:
            return Angle(description.quantise(read_angle()), time, sequence)

        self._newest_at = SampleCache(clock, take)

    def _newest(self) -> Angle:
        return self._newest_at()


class Echo(NamedTuple):
    """The distance of an echo, and the point that it came from."""

    distance: float
    """The distance in metres; ``inf`` if nothing is within the sensor's range."""
    point: tuple[float, float, float] | None
    """The point in the sensor's frame, in metres; None if it is unknown or nothing is within the sensor's range."""


class SampledRangeSensor(RangeSensor):
    """A simulated range sensor.

    measure: returns the echo that the sensor receives now.
    """

    def __init__(self, description: RangeSensorDescription, clock: Clock, measure: Callable[[], Echo]) -> None:
        limits = {"min_range": description.min_range_m, "max_range": description.max_range_m}
        super().__init__(description.name, cone=description.cone_rad, **limits)

        def take(time: float, sequence: int) -> Range:
            echo = measure()
            return Range(echo.distance, time, sequence, echo.point)

        self._newest_at = SampleCache(clock, take)

    def _newest(self) -> Range:
        return self._newest_at()


class SampledCamera(Camera):
    """A simulated camera.

    take_picture: returns a new picture, (height, width, 3), BGR. The camera makes it read-only.
    """

    def __init__(self, name: str, intrinsics: Intrinsics, clock: Clock, take_picture: Callable[[], Image]) -> None:
        super().__init__(name, intrinsics)

        def take(time: float, sequence: int) -> Frame:
            image = take_picture()
            image.flags.writeable = False
            return Frame(image, time, sequence)

        self._newest_at = SampleCache(clock, take)

    def _newest(self) -> Frame:
        return self._newest_at()
