from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from robotcore.errors import DeviceError, RangeFaultError, WheelFaultError
from robotcore.geometry import Pose, Wheels
from robotcore.hal.clock import SteppedClock
from robotcore.safety import Latch, StuckRangeCheck, WheelTrackingCheck
from tests.robotcore.fakes import NullRange

TICK_S = 0.05
STOPPED = Wheels(0.0, 0.0)
Turning = Callable[[float, float], float]


class WheelBench:
    """Two wheels that turn as a function has it of what they are told: the velocity, and the time."""

    def __init__(self, left: Turning = lambda rad_s, _: rad_s, *, count: float = 0.0) -> None:
        self.clock = SteppedClock(20, lambda _: None)
        self.latch = Latch()
        self.commanded, self.turned = [0.0, 0.0], [0.0, 0.0]
        self._left, self._last = left, STOPPED
        self._count = count
        motors = ("left_motor", "right_motor")
        angles = lambda: Wheels(*self.commanded), lambda: Wheels(*map(self._counted, self.turned))
        encoders = ("left_encoder", "right_encoder")
        self._rule = WheelTrackingCheck(self.clock, self.latch, *angles, motors, encoders, patience=1.5, count=count)

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


@pytest.mark.parametrize(
    "share, message",
    [
        (0.0, "left_motor was told to turn 6.0 rad in 1.5 s and turned 0.0 rad by left_encoder"),
        (-1.0, "left_motor was told to turn 6.0 rad in 1.5 s and turned -6.0 rad by left_encoder"),
        (0.2, "turned 1.2 rad"),
    ],
)
def test_a_wheel_that_does_not_follow_latches_by_its_motors_name(share: float, message: str) -> None:
    bench = WheelBench(lambda rad_s, _: share * rad_s)
    with pytest.raises(WheelFaultError, match=message) as raised:
        bench.drive(4.0, 4.0, seconds=2.0)
    assert "right_motor" not in str(raised.value)
    with pytest.raises(WheelFaultError, match=message):
        bench.latch.check()


def test_backwards_too() -> None:
    with pytest.raises(WheelFaultError, match=r"told to turn -6\.0 rad in 1\.5 s and turned 6\.0 rad"):
        WheelBench(lambda rad_s, _: -rad_s).drive(-4.0, 4.0, seconds=2.0)


def test_both_are_named_where_neither_follows() -> None:
    bench = WheelBench(lambda rad_s, _: 0.0)
    bench.turned = [0.0, -100.0]
    bench.drive(4.0, 4.0, seconds=0.1)
    bench.turned[1] = -200.0
    with pytest.raises(WheelFaultError, match=r"left_motor was told.*, right_motor was told"):
        bench.drive(4.0, 4.0, seconds=2.0)


@pytest.mark.parametrize("share", [0.3, 0.7, 1.0, 1.5])
def test_one_that_is_weak_follows(share: float) -> None:
    WheelBench(lambda rad_s, _: share * rad_s).drive(4.0, 4.0, seconds=10.0)


def test_one_that_fails_later_is_found_within_twice_the_patience() -> None:
    bench = WheelBench(lambda rad_s, time: rad_s if time < 2.0 else 0.0)
    with pytest.raises(WheelFaultError):
        bench.drive(4.0, 4.0, seconds=10.0)
    assert bench.clock.now() <= 2.0 + 2 * 1.5 + TICK_S


def test_one_that_is_blocked_for_a_moment_is_none() -> None:
    WheelBench(lambda rad_s, time: 0.0 if time < 1.0 else rad_s).drive(4.0, 4.0, seconds=10.0)


def test_one_that_lags_behind_commands_to_and_fro_is_none() -> None:
    wheel = [0.0]

    def lagging(rad_s: float, _: float) -> float:
        wheel[0] += (rad_s - wheel[0]) * (1 - math.exp(-TICK_S / 0.3))
        return wheel[0]

    bench = WheelBench(lagging)
    for ticks in (2, 5, 9, 17, 33, 45, 60) * 3:
        bench.drive(8.0, 8.0, seconds=ticks * TICK_S)
        bench.drive(-8.0, -8.0, seconds=ticks * TICK_S)


def test_what_it_is_reported_is_judged_only_when_it_is_enough_for_its_encoder() -> None:
    WheelBench(count=math.tau / 8).drive(0.15, 0.15, seconds=60.0)
    WheelBench(lambda _, __: 0.0).drive(0.05, 0.05, seconds=10.0)


def test_standing_begins_anew() -> None:
    bench = WheelBench(lambda _, __: 0.0)
    for _ in range(20):
        bench.drive(4.0, 4.0, seconds=1.0)
        bench.drive(0.0, 0.0, seconds=TICK_S)


TICK_M = 0.01
FORWARD, ON_THE_SPOT, BACKWARD = Wheels(4.0, 4.0), Wheels(-4.0, 4.0), Wheels(-4.0, -4.0)


class RangeBench:
    """A robot that moves as it is put, and what its range sensor reads meanwhile."""

    def __init__(self, distance: float = 1.5) -> None:
        self.nose = NullRange(SteppedClock(20, lambda _: None), distance=distance)
        self.pose = Pose(0.0, 0.0, 0.0)
        self.latch = Latch()
        self._rule = StuckRangeCheck(self.latch, [self.nose], lambda: self.pose, patience=0.5)

    def drive(self, metres: float, turning: float = 0.0, command: Wheels = FORWARD) -> None:
        """Drive so far, turning so much on the way, in rad."""
        ticks = round(metres / TICK_M)
        for _ in range(ticks):
            self.pose = self.pose.advanced(TICK_M, turning / ticks)
            self.ask(command)

    def ask(self, command: Wheels = FORWARD) -> None:
        assert self._rule(command, command) == command


def test_a_sensor_that_tells_the_same_wherever_the_robot_goes_latches_by_its_name() -> None:
    bench = RangeBench()
    with pytest.raises(
        RangeFaultError, match=r"nose told the same 1\.50 m while the wheels drove 0\.\d\d m and turned"
    ):
        bench.drive(0.7, turning=2.0)
    with pytest.raises(RangeFaultError, match="nose"):
        bench.latch.check()


def test_it_is_found_as_soon_as_the_robot_has_driven_so_far_and_turned() -> None:
    bench = RangeBench()
    bench.drive(0.45, turning=1.5)
    bench.drive(0.04)
    with pytest.raises(RangeFaultError):
        bench.drive(0.03)


def test_a_corridor_and_a_wall_alongside_echo_the_same_all_the_way() -> None:
    RangeBench().drive(10.0)


def test_a_turn_on_the_spot_in_a_round_room_changes_nothing_rightly() -> None:
    bench = RangeBench()
    for heading in range(100):
        bench.pose = Pose(0.0, 0.0, 0.1 * heading)
        bench.ask()


@pytest.mark.parametrize("distance", [math.inf, 2.0, 2.5, 0.02])
def test_what_a_sensor_cannot_measure_may_stay_the_same(distance: float) -> None:
    RangeBench(distance).drive(5.0, turning=6.0)


def test_following_what_drives_away_is_no_fault_where_the_gap_breathes() -> None:
    bench = RangeBench()
    for tick in range(300):
        bench.nose.distance = 1.5 + 0.003 * math.sin(tick / 5)
        bench.drive(TICK_M, turning=0.02)


def test_a_sensor_that_counts_whole_centimetres_is_none() -> None:
    bench = RangeBench()
    for tick in range(120):
        bench.nose.distance = round(1.9 - 0.01 * tick * math.cos(0.01 * tick), 2)
        bench.drive(TICK_M, turning=0.01)


def test_one_other_reading_begins_anew() -> None:
    bench = RangeBench()
    for _ in range(5):
        bench.drive(0.4, turning=1.5)
        bench.nose.distance += 0.002


def test_a_sample_that_does_not_come_is_not_the_same_reported_again() -> None:
    bench = RangeBench()
    bench.drive(0.1)
    same = bench.nose.read()
    bench.nose._newest = lambda: same  # type: ignore[method-assign]
    bench.drive(5.0, turning=6.0)


@pytest.mark.parametrize("command", [ON_THE_SPOT, BACKWARD, Wheels(0.0, 0.0)])
def test_nothing_is_read_where_the_robot_would_not_move_forward(command: Wheels) -> None:
    bench = RangeBench()

    def gone() -> None:
        raise DeviceError("nose", "is gone")

    bench.nose._newest = gone  # type: ignore[assignment,method-assign]
    bench.drive(5.0, turning=6.0, command=command)
    with pytest.raises(DeviceError, match="nose"):
        bench.ask(FORWARD)
