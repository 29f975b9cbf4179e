from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from robotcore.errors import DeviceError, RangeFaultError, WheelFaultError
from robotcore.geometry import Pose, Wheels
from robotcore.hal.clock import SteppedClock
from robotcore.safety.latch import Latch
from robotcore.safety.sensor_checks import StuckRangeCheck, WheelTrackingCheck
from tests.robotcore.fakes import NullRange, look_ahead
from tests.texts import Raises

TICK_S = 0.05
STOPPED = Wheels(0.0, 0.0)
Turning = Callable[[float, float], float]


class WheelBench:
    """Two wheels. The left one turns with the velocity that a function of command and time returns."""

    def __init__(self, left: Turning = lambda rad_s, _: rad_s, *, count: float = 0.0) -> None:
        self.clock = SteppedClock(20, lambda _: None)
        self.latch = Latch()
        self.commanded, self.turned = [0.0, 0.0], [0.0, 0.0]
        self._left, self._last = left, STOPPED
        self._count = count
        motors = ("left_motor", "right_motor")
        angles = lambda: Wheels(*self.commanded), lambda: Wheels(*map(self._counted, self.turned))
        encoders = ("left_encoder", "right_encoder")
        self._rule = WheelTrackingCheck(
            self.clock, self.latch, *angles, motors, encoders, min_duration_s=1.5, count=count
        )

    def drive(self, left: float, right: float, seconds: float = TICK_S) -> None:
        for _ in range(round(seconds / TICK_S)):
            assert self._rule(Wheels(left, right), self._last) == (left, right)
            self._last = Wheels(left, right)
            turned = (self._left(left, self.clock.now()), right)
            for side, (asked, done) in enumerate(zip((left, right), turned, strict=True)):
                self.commanded[side] += asked * TICK_S
                self.turned[side] += done * TICK_S
            self.clock.sleep_until(self.clock.now() + TICK_S)

    def _counted(self, angle: float) -> float:
        return math.floor(angle / self._count) * self._count if self._count else angle


@pytest.mark.parametrize("share", [0.0, -1.0, 0.2])
def test_wheel_that_does_not_follow_trips_the_latch(raises: Raises, share: float) -> None:
    bench = WheelBench(lambda rad_s, _: share * rad_s)
    with raises(WheelFaultError) as raised:
        bench.drive(4.0, 4.0, seconds=2.0)
    assert bench.latch.error is raised.value


def test_wheel_that_drives_backwards_is_checked(raises: Raises) -> None:
    with raises(WheelFaultError):
        WheelBench(lambda rad_s, _: -rad_s).drive(-4.0, 4.0, seconds=2.0)


def test_error_names_both_wheels_if_neither_follows(raises: Raises) -> None:
    bench = WheelBench(lambda rad_s, _: 0.0)
    bench.turned = [0.0, -100.0]
    bench.drive(4.0, 4.0, seconds=0.1)
    bench.turned[1] = -200.0
    with raises(WheelFaultError):
        bench.drive(4.0, 4.0, seconds=2.0)


@pytest.mark.parametrize("share", [0.3, 0.7, 1.0, 1.5])
def test_weak_wheel_does_not_trip_the_latch(share: float) -> None:
    WheelBench(lambda rad_s, _: share * rad_s).drive(4.0, 4.0, seconds=10.0)


def test_wheel_that_stops_later_trips_the_latch_within_two_checks() -> None:
    bench = WheelBench(lambda rad_s, time: rad_s if time < 2.0 else 0.0)
    with pytest.raises(WheelFaultError):
        bench.drive(4.0, 4.0, seconds=10.0)
    assert bench.clock.now() <= 2.0 + 2 * 1.5 + TICK_S


def test_lag_behind_alternating_commands_does_not_trip_the_latch() -> None:
    wheel = [0.0]

    def lagging(rad_s: float, _: float) -> float:
        wheel[0] += (rad_s - wheel[0]) * (1 - math.exp(-TICK_S / 0.3))
        return wheel[0]

    bench = WheelBench(lagging)
    for ticks in (2, 5, 9, 17, 33, 45, 60) * 3:
        bench.drive(8.0, 8.0, seconds=ticks * TICK_S)
        bench.drive(-8.0, -8.0, seconds=ticks * TICK_S)


def test_angle_too_small_for_the_encoder_is_not_checked() -> None:
    WheelBench(count=math.tau / 8).drive(0.15, 0.15, seconds=60.0)
    WheelBench(lambda _, __: 0.0).drive(0.05, 0.05, seconds=10.0)


def test_standing_begins_a_new_check() -> None:
    bench = WheelBench(lambda _, __: 0.0)
    for _ in range(20):
        bench.drive(4.0, 4.0, seconds=1.0)
        bench.drive(0.0, 0.0, seconds=TICK_S)


TICK_M = 0.01
FORWARD, ON_THE_SPOT, BACKWARD = Wheels(4.0, 4.0), Wheels(-4.0, 4.0), Wheels(-4.0, -4.0)


class RangeBench:
    """A robot that a test moves, with a range sensor."""

    def __init__(self, distance: float = 1.0) -> None:
        clock = SteppedClock(20, lambda _: None)
        self.nose = NullRange(clock, distance=distance)
        self.pose, self.pose_reads = Pose(0.0, 0.0, 0.0), 0
        self.latch = Latch()
        self._rule = StuckRangeCheck(self.latch, [look_ahead(self.nose, clock)], self._read_pose, min_distance_m=0.5)

    def drive(self, metres: float, turning: float = 0.0, command: Wheels = FORWARD) -> None:
        """Drive ``metres`` while turning by ``turning`` rad in all."""
        ticks = round(metres / TICK_M)
        for _ in range(ticks):
            self.pose = self.pose.advance(TICK_M, turning / ticks)
            self.request(command)

    def request(self, command: Wheels = FORWARD) -> None:
        assert self._rule(command, command) == command

    def _read_pose(self) -> Pose:
        self.pose_reads += 1
        return self.pose


@pytest.mark.parametrize("command", [FORWARD, ON_THE_SPOT, BACKWARD])
def test_pose_is_read_for_each_command(command: Wheels) -> None:
    bench = RangeBench()
    bench.request(command)
    assert bench.pose_reads == 1


def test_sensor_that_always_measures_the_same_distance_trips_the_latch(raises: Raises) -> None:
    bench = RangeBench()
    with raises(RangeFaultError) as raised:
        bench.drive(0.7, turning=2.0)
    assert bench.latch.error is raised.value


def test_latch_trips_once_the_robot_has_driven_and_turned_enough() -> None:
    bench = RangeBench()
    bench.drive(0.45, turning=1.5)
    bench.drive(0.04)
    with pytest.raises(RangeFaultError):
        bench.drive(0.03)


def test_same_distance_along_a_straight_wall_does_not_trip_the_latch() -> None:
    RangeBench().drive(10.0)


def test_same_distance_during_a_turn_on_the_spot_does_not_trip_the_latch() -> None:
    bench = RangeBench()
    for heading in range(100):
        bench.pose = Pose(0.0, 0.0, 0.1 * heading)
        bench.request()


@pytest.mark.parametrize("distance", [math.inf, 2.0, 2.5, 0.02])
def test_distance_outside_of_the_sensors_range_may_stay_the_same(distance: float) -> None:
    RangeBench(distance).drive(5.0, turning=6.0)


def test_readings_in_whole_centimetres_do_not_trip_the_latch() -> None:
    bench = RangeBench()
    for tick in range(120):
        bench.nose.distance = round(1.9 - 0.01 * tick * math.cos(0.01 * tick), 2)
        bench.drive(TICK_M, turning=0.01)


def test_one_different_reading_begins_a_new_check() -> None:
    bench = RangeBench()
    for _ in range(5):
        bench.drive(0.4, turning=1.5)
        bench.nose.distance += 0.002


def test_missing_sample_does_not_count_as_the_same_distance() -> None:
    bench = RangeBench()
    bench.drive(0.1)
    same = bench.nose.read()
    bench.nose._newest = lambda: same  # type: ignore[method-assign]
    bench.drive(5.0, turning=6.0)


@pytest.mark.parametrize("command", [ON_THE_SPOT, BACKWARD, Wheels(0.0, 0.0)])
def test_sensor_is_not_read_unless_the_robot_moves_forward(command: Wheels) -> None:
    bench = RangeBench()

    def gone() -> None:
        raise DeviceError("nose", "is gone")

    bench.nose._newest = gone  # type: ignore[assignment,method-assign]
    bench.drive(5.0, turning=6.0, command=command)
    with pytest.raises(DeviceError):
        bench.request(FORWARD)
