"""A stop during a commit prevents the command."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest

from robotcore.errors import DeviceError, EmergencyStopError
from robotcore.geometry import Wheels
from robotcore.hal.clock import SteppedClock, TickClock
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.safety.command_filter import SafetyFilter
from robotcore.safety.latch import Latch
from robotcore.safety.motor_stop import StopGroup
from robotcore.safety.thread_reserve import Reserve
from robotcore.safety.wheel_output import SideMotors
from tests.robotcore.fakes import NullMotor


class Meanwhile:
    """A rule that calls a function in another thread, and halves the command."""

    cause = "meanwhile"

    def __init__(self) -> None:
        self.action: Callable[[], object] | None = None

    def __call__(self, asked: Wheels, last: Wheels) -> Wheels:
        if self.action is None:
            return asked
        thread = threading.Thread(target=self.action)
        thread.start()
        thread.join()
        return Wheels(asked.left / 2, asked.right / 2)


class Bench:
    """A safety filter that drives both motors at 2 rad/s, with a rule that may call a function."""

    def __init__(self) -> None:
        self.latch, self.left, self.right, self.rule = Latch(), NullMotor("left"), NullMotor("right"), Meanwhile()
        clock = TickClock(SteppedClock(20, lambda _: None))
        self.filter = SafetyFilter(clock, SideMotors([self.left], [self.right]), [self.rule], 0.125, self.latch)
        self.filter.ask(Wheels(2.0, 2.0))
        self.filter.commit()


@pytest.mark.parametrize(
    "stop", [lambda bench: bench.latch.set(EmergencyStopError("now")), lambda bench: bench.filter.stop()]
)
def test_a_stop_during_a_commit_prevents_the_command(stop: Callable[[Bench], object]) -> None:
    bench = Bench()
    bench.rule.action = lambda: stop(bench)
    assert bench.filter.commit().sent == (0.0, 0.0)
    for motor in (bench.left, bench.right):
        assert motor.sent[0] == 2.0
        assert set(motor.sent[1:]) == {0.0}


@pytest.fixture
def clock() -> Iterator[MonotonicClock]:
    real = MonotonicClock()
    yield real
    with suppress(DeviceError):  # a failed stop of the deadman in its thread
        real.close()


def test_deadman_stops_the_other_motor_if_one_hangs(clock: MonotonicClock) -> None:
    left, right = NullMotor("left"), NullMotor("right")
    release, stopped = threading.Event(), threading.Event()
    reserve = Reserve(clock)
    reserve.hold(threads=2)

    def hang(rad_s: float) -> None:
        if rad_s == 0:
            release.wait()

    left.on_command = hang
    right.on_command = lambda rad_s: stopped.set() if rad_s == 0 else None

    def drive() -> None:
        filter_ = SafetyFilter(
            clock, SideMotors([left], [right]), [], 0.1, motor_stops=StopGroup.create(left, right, reserve=reserve)
        )
        filter_.ask(Wheels(2.0, 2.0))
        filter_.commit()
        filter_.stop()

    driving = threading.Thread(target=drive)
    driving.start()
    is_stopped = stopped.wait(30)
    is_hung = driving.is_alive()
    release.set()
    driving.join()
    reserve.close()
    assert is_stopped
    assert is_hung
