"""The angles of a drive's two wheels, from encoders, from commands, and from the steering angle."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Sequence

from robotcore.geometry import DifferentialGeometry, Wheels
from robotcore.hal.clock import Clock
from robotcore.hal.drive import CommandIntegrator, WheelPath
from robotcore.hal.joint import Joint
from robotcore.kinds.encoder import Angle, Encoder
from robotcore.runtime.layers.encoder_polling import EncoderPolling, TimedAngles, compute_mean_angles

SAME_POSE_M = 1e-5
"""A path with polls that leads to a pose nearer than this to the pose after one arc, in metres, becomes one arc."""

COUNT_SHARE = 0.3
"""The share of a count by which the area of a path may be wrong, for each radian that the wheels turn.

Below it, the rounding to counts hides the true path. With less, coarse encoders would make the pose worse.
"""

ReadCourse = Callable[[], Sequence[TimedAngles]]
"""A function that returns the angles of the wheels since its last call, the oldest first. The last ones are present."""


def read_angles(left: Sequence[Encoder], right: Sequence[Encoder]) -> Wheels:
    """Return the mean angles that the encoders of each side have measured, in radians."""
    return compute_mean_angles([each.read() for each in left], [each.read() for each in right])


class PresentAngles:
    """Reads the mean of the present angles of each side in radians.

    The present angle is the encoder's angle plus the rotation that was commanded since the sample was captured.
    Further calls with the same samples at the same time return the same object.
    """

    def __init__(
        self, left: Sequence[Encoder], right: Sequence[Encoder], commanded: CommandIntegrator, clock: Clock
    ) -> None:
        self._encoders, self._left_count = (*left, *right), len(left)
        self._commanded, self._clock = commanded, clock
        self._samples: list[Angle] = []
        self._read_at = math.nan
        self._angles = Wheels(0.0, 0.0)

    def __call__(self) -> Wheels:
        samples, now = [each.read() for each in self._encoders], self._clock.now()
        if now != self._read_at or not all(map(operator.is_, samples, self._samples)):
            left, right = samples[: self._left_count], samples[self._left_count :]
            self._angles = compute_present_angles(left, right, self._commanded)
            self._samples, self._read_at = samples, now
        return self._angles


def compute_present_angles(left: Sequence[Angle], right: Sequence[Angle], commanded: CommandIntegrator) -> Wheels:
    """Return the mean of the present angles of each side in radians, from the samples of its encoders."""
    return Wheels(
        sum(each.angle + commanded.rotation_since(each.time).left for each in left) / len(left),
        sum(each.angle + commanded.rotation_since(each.time).right for each in right) / len(right),
    )


class PolledAngles:
    """Returns the angles of a tick, and before them those of the polls since the last tick.

    The angles of the ticks define the rotation of each wheel in between, because they have passed all layers: faults,
    the recorder and the age limit. The polls define only its course. If the polls turned farther or less far than the
    ticks, the difference is spread evenly over the time.

    read: reads the present angles of a tick, in radians.
    polling: the polls.
    """

    def __init__(
        self, read: Callable[[], Wheels], polling: EncoderPolling, commanded: CommandIntegrator, clock: Clock
    ) -> None:
        self._read, self._polling, self._commanded, self._clock = read, polling, commanded, clock
        self._last: TimedAngles | None = None
        self._last_polled = Wheels(0.0, 0.0)

    def __call__(self) -> Sequence[TimedAngles]:
        """Return the angles since the last call."""
        angles, now, last = self._read(), self._clock.now(), self._last
        if last and angles is last.angles:  # a further reading in a tick
            return (last,)
        if (samples := self._polling.list_read()) is None:
            return (TimedAngles(now, angles),)
        left, right = samples
        present = TimedAngles(max(now, *(each.time for each in (*left, *right))), angles)
        polled, last_polled = compute_present_angles(left, right, self._commanded), self._last_polled
        self._last, self._last_polled = present, polled
        return (*self._list_between(last, last_polled, present, polled), present) if last else (present,)

    def _list_between(
        self, last: TimedAngles, last_polled: Wheels, present: TimedAngles, polled: Wheels
    ) -> Iterator[TimedAngles]:
        """Yield the angles at the times of the polls between two ticks.

        last, present: the angles in the two ticks.
        last_polled, polled: the angles in the two ticks without the layers.
        """
        missing_left = present.angles.left - last.angles.left - (polled.left - last_polled.left)
        missing_right = present.angles.right - last.angles.right - (polled.right - last_polled.right)
        for time, point in self._polling.take(last.time, present.time):
            share = (time - last.time) / (present.time - last.time)
            left = last.angles.left + point.left - last_polled.left + missing_left * share
            right = last.angles.right + point.right - last_polled.right + missing_right * share
            yield TimedAngles(time, Wheels(left, right))


class SteeredAngles:
    """Computes the angles of two rear wheels from their mean angle and the motion of the servo that steers.

    read: a function that returns angles in radians, of which only the mean counts.
    joint: the motion of the servo.
    ratio: half of the distance between the wheels, divided by the distance between the axles.
    """

    def __init__(self, read: ReadCourse, joint: Joint, clock: Clock, ratio: float) -> None:
        self._read, self._joint, self._ratio = read, joint, ratio
        self._since, self._mean = clock.now(), 0.0
        self._angles = Wheels(0.0, 0.0)

    def __call__(self) -> Sequence[TimedAngles]:
        """Return the angles of the rear wheels since the last call."""
        return [TimedAngles(time, self._advance(time, (left + right) / 2)) for time, (left, right) in self._read()]

    def _advance(self, time: float, mean: float) -> Wheels:
        turned = mean - self._mean
        shift = turned * self._ratio * self._joint.mean_tangent(self._since, time)
        self._angles = Wheels(self._angles.left + turned - shift, self._angles.right + turned + shift)
        self._since, self._mean = time, mean
        return self._angles


class WheelPathReader:
    """Returns the path of the wheels since the last call.

    The path has no angles in between if one arc leads to the same pose, within `SAME_POSE_M` or the error of the
    encoders. So a robot whose wheels turn evenly needs no more arcs, and no longer recording, than without polls.

    count: the rotation of a wheel for one count of the coarser encoder, in rad.
    """

    def __init__(self, read: ReadCourse, geometry: DifferentialGeometry, count: float = 0.0) -> None:
        self._read, self._last = read, Wheels(0.0, 0.0)
        self._min_area = SAME_POSE_M * geometry.track / geometry.wheel_radius**2
        self._min_ratio = COUNT_SHARE * count

    def __call__(self) -> WheelPath:
        """Read the angles, and return the path."""
        *between, (_, angles) = self._read()
        last, self._last = self._last, angles
        if between:
            points = tuple(each for _, each in between)
            turned = abs(angles.left - last.left) + abs(angles.right - last.right)
            if abs(_compute_area((last, *points, angles))) >= max(self._min_area, self._min_ratio * turned):
                return WheelPath(angles, points)
        return WheelPath(angles)


def _compute_area(angles: Sequence[Wheels]) -> float:
    """Return the area between a path in the plane of both angles and the straight line to its end, in square radians.

    The area of the distance and the heading is the sideways distance between the path and one arc. It is this area,
    multiplied by the squared wheel radius and divided by the track.
    """
    first = angles[0]
    area = left = right = 0.0
    for each in angles:
        next_left, next_right = each.left - first.left, each.right - first.right
        area += left * next_right - right * next_left
        left, right = next_left, next_right
    return area / 2
