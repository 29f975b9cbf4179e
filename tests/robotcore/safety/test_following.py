from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from robotcore.errors import WheelFaultError
from robotcore.geometry import Wheels
from robotcore.hal.clock import SteppedClock
from robotcore.safety import Latch, WheelsFollow

TICK_S = 0.05
REST = Wheels(0.0, 0.0)
Turning = Callable[[float, float], float]


class Bench:
    """Two wheels that turn as a function has it of what they are told: the velocity, and the time."""

    def __init__(self, left: Turning = lambda rad_s, _: rad_s, *, count: float = 0.0) -> None:
        self.clock = SteppedClock(20, lambda _: None)
        self.latch = Latch()
        self.told, self.turned = [0.0, 0.0], [0.0, 0.0]
        self._left, self._last = left, REST
        self._count = count
        motors = ("left_motor", "right_motor")
        angles = lambda: Wheels(*self.told), lambda: Wheels(*map(self._counted, self.turned))
        encoders = ("left_encoder", "right_encoder")
        self._rule = WheelsFollow(self.clock, self.latch, *angles, motors, encoders, patience=1.5, count=count)

    def drive(self, left: float, right: float, seconds: float = TICK_S) -> None:
        for _ in range(round(seconds / TICK_S)):
            assert self._rule(Wheels(left, right), self._last) == (left, right)
            self._last = Wheels(left, right)
            turned = (self._left(left, self.clock.now()), right)
            for side, (asked, done) in enumerate(zip((left, right), turned, strict=True)):
                self.told[side] += asked * TICK_S
                self.turned[side] += done * TICK_S
            self.clock.sleep_until(self.clock.now() + TICK_S)

    def _counted(self, angle: float) -> float:
        return math.floor(angle / self._count) * self._count if self._count else angle


@pytest.mark.parametrize(
    "share, told",
    [
        (0.0, "left_motor was told to turn 6.0 rad in 1.5 s and turned 0.0 rad by left_encoder"),
        (-1.0, "left_motor was told to turn 6.0 rad in 1.5 s and turned -6.0 rad by left_encoder"),
        (0.2, "turned 1.2 rad"),
    ],
)
def test_a_wheel_that_does_not_follow_latches_by_its_motors_name(share: float, told: str) -> None:
    bench = Bench(lambda rad_s, _: share * rad_s)
    with pytest.raises(WheelFaultError, match=told) as raised:
        bench.drive(4.0, 4.0, seconds=2.0)
    assert "right_motor" not in str(raised.value)
    with pytest.raises(WheelFaultError, match=told):
        bench.latch.check()


def test_backwards_too() -> None:
    with pytest.raises(WheelFaultError, match=r"told to turn -6\.0 rad in 1\.5 s and turned 6\.0 rad"):
        Bench(lambda rad_s, _: -rad_s).drive(-4.0, 4.0, seconds=2.0)


def test_both_are_named_where_neither_follows() -> None:
    bench = Bench(lambda rad_s, _: 0.0)
    bench.turned = [0.0, -100.0]
    bench.drive(4.0, 4.0, seconds=0.1)
    bench.turned[1] = -200.0
    with pytest.raises(WheelFaultError, match=r"left_motor was told.*, right_motor was told"):
        bench.drive(4.0, 4.0, seconds=2.0)


@pytest.mark.parametrize("share", [0.3, 0.7, 1.0, 1.5])
def test_one_that_is_weak_follows(share: float) -> None:
    Bench(lambda rad_s, _: share * rad_s).drive(4.0, 4.0, seconds=10.0)


def test_one_that_fails_later_is_found_within_twice_the_patience() -> None:
    bench = Bench(lambda rad_s, time: rad_s if time < 2.0 else 0.0)
    with pytest.raises(WheelFaultError):
        bench.drive(4.0, 4.0, seconds=10.0)
    assert bench.clock.now() <= 2.0 + 2 * 1.5 + TICK_S


def test_one_that_is_blocked_for_a_moment_is_none() -> None:
    Bench(lambda rad_s, time: 0.0 if time < 1.0 else rad_s).drive(4.0, 4.0, seconds=10.0)


def test_one_that_lags_behind_commands_to_and_fro_is_none() -> None:
    wheel = [0.0]

    def lagging(rad_s: float, _: float) -> float:
        wheel[0] += (rad_s - wheel[0]) * (1 - math.exp(-TICK_S / 0.3))
        return wheel[0]

    bench = Bench(lagging)
    for ticks in (2, 5, 9, 17, 33, 45, 60) * 3:
        bench.drive(8.0, 8.0, seconds=ticks * TICK_S)
        bench.drive(-8.0, -8.0, seconds=ticks * TICK_S)


def test_what_it_is_told_is_judged_only_when_it_is_enough_for_its_encoder() -> None:
    Bench(count=math.tau / 8).drive(0.15, 0.15, seconds=60.0)
    Bench(lambda _, __: 0.0).drive(0.05, 0.05, seconds=10.0)


def test_standing_begins_anew() -> None:
    bench = Bench(lambda _, __: 0.0)
    for _ in range(20):
        bench.drive(4.0, 4.0, seconds=1.0)
        bench.drive(0.0, 0.0, seconds=TICK_S)
