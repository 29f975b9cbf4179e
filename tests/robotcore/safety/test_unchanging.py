from __future__ import annotations

import math

import pytest

from robotcore.errors import DeviceError, RangeFaultError
from robotcore.geometry import Pose, Wheels
from robotcore.hal.clock import SteppedClock
from robotcore.safety import Latch, RangesChange
from tests.robotcore.fakes import NullRange

TICK_M = 0.01
FORWARD, ON_THE_SPOT, BACKWARD = Wheels(4.0, 4.0), Wheels(-4.0, 4.0), Wheels(-4.0, -4.0)


class Bench:
    """A robot that moves as it is put, and what its range sensor reads meanwhile."""

    def __init__(self, distance: float = 1.5) -> None:
        self.nose = NullRange(SteppedClock(20, lambda _: None), distance=distance)
        self.pose = Pose(0.0, 0.0, 0.0)
        self.latch = Latch()
        self._rule = RangesChange(self.latch, [self.nose], lambda: self.pose, patience=0.5)

    def drive(self, metres: float, turning: float = 0.0, command: Wheels = FORWARD) -> None:
        """Drive so far, turning so much on the way, in rad."""
        ticks = round(metres / TICK_M)
        for _ in range(ticks):
            self.pose = self.pose.advanced(TICK_M, turning / ticks)
            self.ask(command)

    def ask(self, command: Wheels = FORWARD) -> None:
        assert self._rule(command, command) == command


def test_a_sensor_that_tells_the_same_wherever_the_robot_goes_latches_by_its_name() -> None:
    bench = Bench()
    with pytest.raises(
        RangeFaultError, match=r"nose told the same 1\.50 m while the wheels drove 0\.\d\d m and turned"
    ):
        bench.drive(0.7, turning=2.0)
    with pytest.raises(RangeFaultError, match="nose"):
        bench.latch.check()


def test_it_is_found_as_soon_as_the_robot_has_driven_so_far_and_turned() -> None:
    bench = Bench()
    bench.drive(0.45, turning=1.5)
    bench.drive(0.04)
    with pytest.raises(RangeFaultError):
        bench.drive(0.03)


def test_a_corridor_and_a_wall_alongside_echo_the_same_all_the_way() -> None:
    Bench().drive(10.0)


def test_a_turn_on_the_spot_in_a_round_room_changes_nothing_rightly() -> None:
    bench = Bench()
    for heading in range(100):
        bench.pose = Pose(0.0, 0.0, 0.1 * heading)
        bench.ask()


@pytest.mark.parametrize("distance", [math.inf, 2.0, 2.5, 0.02])
def test_what_a_sensor_cannot_measure_may_stay_the_same(distance: float) -> None:
    Bench(distance).drive(5.0, turning=6.0)


def test_following_what_drives_away_is_no_fault_where_the_gap_breathes() -> None:
    bench = Bench()
    for tick in range(300):
        bench.nose.distance = 1.5 + 0.003 * math.sin(tick / 5)
        bench.drive(TICK_M, turning=0.02)


def test_a_sensor_that_counts_whole_centimetres_is_none() -> None:
    bench = Bench()
    for tick in range(120):
        bench.nose.distance = round(1.9 - 0.01 * tick * math.cos(0.01 * tick), 2)
        bench.drive(TICK_M, turning=0.01)


def test_one_other_reading_begins_anew() -> None:
    bench = Bench()
    for _ in range(5):
        bench.drive(0.4, turning=1.5)
        bench.nose.distance += 0.002


def test_a_sample_that_does_not_come_is_not_the_same_told_again() -> None:
    bench = Bench()
    bench.drive(0.1)
    same = bench.nose.read()
    bench.nose._newest = lambda: same  # type: ignore[method-assign]
    bench.drive(5.0, turning=6.0)


@pytest.mark.parametrize("command", [ON_THE_SPOT, BACKWARD, Wheels(0.0, 0.0)])
def test_nothing_is_read_where_the_robot_would_not_move_forward(command: Wheels) -> None:
    bench = Bench()

    def gone() -> None:
        raise DeviceError("nose", "is gone")

    bench.nose._newest = gone  # type: ignore[assignment,method-assign]
    bench.drive(5.0, turning=6.0, command=command)
    with pytest.raises(DeviceError, match="nose"):
        bench.ask(FORWARD)
