"""Checks of the sensors: wheels that do not follow their commands, and range readings that never change."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import copysign, degrees, inf

from robotcore.errors import RangeFaultError, WheelFaultError
from robotcore.geometry import Pose, Wheels, wrap_angle
from robotcore.hal.clock import Clock
from robotcore.hal.device import Sample
from robotcore.safety.latch import Latch
from robotcore.safety.sensor_ahead import SensorAhead

MIN_RESPONSE = 0.25
"""The least share of the commanded angle that a wheel must turn. With lag, slip or a flat battery it turns more."""

MIN_ANGLE_RAD = 1.0
"""The least commanded angle of a check, in radians. The wheel's lag would be too large a share of a smaller one."""

MIN_COUNTS = 4
"""The least commanded angle of a check, in counts of the encoder. It matters for coarse encoders."""


class WheelTrackingCheck:
    """Trips the latch if a wheel does not follow its command. As a rule of the command filter, it changes no command.

    A check covers a time in which a wheel turns in one direction: at least ``min_duration_s``, and at least
    `MIN_ANGLE_RAD` of commanded rotation.

    commanded: a function that returns the commanded angles of both wheels, in rad.
    turned: a function that returns the angles that the encoders have measured, in rad.
    motors, encoders: the names of the left and the right motor, and of the left and the right encoder.
    min_duration_s: the least duration of a check, in seconds.
    count: the rotation of a wheel for one count of the coarser encoder, in rad.
    """

    cause = "wheel fault"

    def __init__(
        self,
        clock: Clock,
        latch: Latch,
        commanded: Callable[[], Wheels],
        turned: Callable[[], Wheels],
        motors: tuple[str, str],
        encoders: tuple[str, str],
        min_duration_s: float,
        count: float = 0.0,
    ) -> None:
        self._clock, self._latch, self._commanded, self._turned = clock, latch, commanded, turned
        min_angle = max(MIN_ANGLE_RAD, MIN_COUNTS * count)
        self._wheels = [_WheelCheck(*names, min_duration_s, min_angle) for names in zip(motors, encoders, strict=True)]

    def __call__(self, command: Wheels, last: Wheels) -> Wheels:
        now, commanded, turned = self._clock.now(), self._commanded(), self._turned()
        checks = [wheel.check(now, *each) for wheel, *each in zip(self._wheels, last, commanded, turned, strict=True)]
        if problems := [*dict.fromkeys(problem for problem in checks if problem)]:  # both wheels may have one motor
            self._latch.trip(WheelFaultError(problems))
        return command


class _WheelCheck:
    def __init__(self, motor: str, encoder: str, min_duration_s: float, min_angle: float) -> None:
        self._motor, self._encoder = motor, encoder
        self._min_duration_s, self._min_angle = min_duration_s, min_angle
        self._begin(0.0, 0.0, 0.0, 0.0)

    def check(self, now: float, velocity: float, commanded: float, turned: float) -> str:
        """Return a clause if the wheel does not follow its command, otherwise an empty text.

        now: the time, in seconds.
        velocity: the velocity that was sent last, in rad/s.
        commanded, turned: the commanded and the measured angle, in rad.
        """
        direction = copysign(1.0, velocity) if velocity else 0.0
        if direction == 0.0 or direction != self._direction:
            self._begin(now, direction, commanded, turned)
            return ""
        goal, actual, duration = commanded - self._commanded, turned - self._turned, now - self._since
        if duration < self._min_duration_s or abs(goal) < self._min_angle:
            return ""
        self._begin(now, direction, commanded, turned)
        if actual * direction >= MIN_RESPONSE * abs(goal):
            return ""
        measured = f"{self._encoder} measured {round(actual, 1) + 0.0} rad"  # no -0.0
        return f"{self._motor} was commanded to turn {goal:.1f} rad in {duration:.1f} s and {measured}"

    def _begin(self, now: float, direction: float, commanded: float, turned: float) -> None:
        self._since, self._direction, self._commanded, self._turned = now, direction, commanded, turned


SAME_DISTANCE_M = 0.001
"""Two distances count as the same if they differ by less than this, in metres.

A working sensor measures a larger difference, because a robot moves about 10 mm in a tick.
"""

MIN_TURN_RAD = 1.0
"""The least angle by which the robot turns during a check, in radians.

A working sensor with a wide cone may measure the same distance all along a wall.
"""


class StuckRangeCheck:
    """Trips the latch if a sensor repeats one distance ahead while the robot moves.

    As a rule of the command filter, it changes no command. It reads the sensors only while the robot drives forward. A
    reading at a limit of the sensor's range may repeat.

    pose: a function that returns the pose by the encoders. By the commands, a blocked robot would seem to move.
    min_distance_m: the least distance that the robot drives during a check, in metres. It must also turn by
    `MIN_TURN_RAD`.
    """

    cause = "range fault"

    def __init__(
        self, latch: Latch, sensors: Iterable[SensorAhead], pose: Callable[[], Pose], min_distance_m: float
    ) -> None:
        self._latch, self._pose = latch, pose
        self._sensors = [_RangeHistory(sensor, min_distance_m) for sensor in sensors]

    def __call__(self, command: Wheels, last: Wheels) -> Wheels:
        pose = self._pose()  # in each tick, because the pose of a robot that steers adds up short arcs
        if command.left + command.right <= 0:
            return command
        if problems := [problem for problem in (sensor.check(pose) for sensor in self._sensors) if problem]:
            self._latch.trip(RangeFaultError(problems))
        return command


class _RangeHistory:
    """The last distance of one sensor, and the motion of the robot since the distance changed."""

    def __init__(self, sensor: SensorAhead, min_distance_m: float) -> None:
        self._sensor, self._min_distance_m = sensor, min_distance_m
        self._shortest: float = getattr(sensor.device, "min_range", 0.0)
        self._longest: float = getattr(sensor.device, "max_range", inf)
        self._last: Sample | None = None
        self._at = Pose(0.0, 0.0, 0.0)
        self._distance = self._driven = self._turned = 0.0

    def check(self, pose: Pose) -> str:
        """Read the sensor. Return a clause if it repeats its distance, otherwise an empty text."""
        reading = self._sensor.device.read()
        if self._last and reading.sequence == self._last.sequence:
            return ""
        self._last, distance = reading, self._sensor.measure(reading)
        if not self._repeats(distance):
            self._begin(distance, pose)
            return ""
        self._driven += pose.distance_to(self._at.x, self._at.y)
        self._turned += abs(wrap_angle(pose.heading - self._at.heading))
        self._at = pose
        if self._driven < self._min_distance_m or self._turned < MIN_TURN_RAD:
            return ""
        motion = f"drove {self._driven:.2f} m and turned {degrees(self._turned):.0f}°"
        return f"{self._sensor.device.name} measured the same {self._distance:.2f} m while the wheels {motion}"

    def _repeats(self, distance: float) -> bool:
        is_measured = self._shortest < distance < self._longest
        return is_measured and abs(distance - self._distance) < SAME_DISTANCE_M

    def _begin(self, distance: float, pose: Pose) -> None:
        self._distance, self._at = distance, pose
        self._driven = self._turned = 0.0
