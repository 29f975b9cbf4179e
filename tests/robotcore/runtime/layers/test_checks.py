from __future__ import annotations

import math

import pytest

from robotcore.errors import BackendError, DeviceError, RobotcoreError, StaleSampleError
from robotcore.hal.clock import SteppedClock, TickClock
from robotcore.kinds.range_sensor import Range
from robotcore.runtime.layers.base import MotorOutput
from robotcore.runtime.layers.checks import CallMonitorLayer, MaxAgeLayer
from robotcore.safety.latch import Latch
from robotcore.safety.watchdog import ActivityMonitor, TimeLimit
from tests.robotcore.fakes import NullMotor, NullRange, Rig
from tests.texts import CheckText, Raises


def test_sample_beyond_the_age_limit_ends_the_run_even_if_the_app_catches_the_error() -> None:
    clock, latch = TickClock(SteppedClock(20, lambda _: None)), Latch()
    read = MaxAgeLayer(clock, 0.5, 3.0, latch).sensor(NullRange(clock), lambda: Range(1.0, 0.0, 0))
    clock.sleep_until(0.5)
    read()
    latch.check()
    clock.sleep_until(0.55)
    with pytest.raises(StaleSampleError) as raised:
        read()
    assert [raised.value.age, raised.value.limit] == pytest.approx([0.55, 0.5])
    with pytest.raises(StaleSampleError):
        latch.check()


@pytest.mark.parametrize("time", [math.nan, 1e9])
def test_sample_with_the_time_of_another_clock_ends_the_run(time: float) -> None:
    clock, latch = TickClock(SteppedClock(20, lambda _: None)), Latch()
    read = MaxAgeLayer(clock, 0.5, 3.0, latch).sensor(NullRange(clock), lambda: Range(1.0, time, 0))
    with pytest.raises(StaleSampleError):
        read()


def test_sample_may_be_newer_than_the_begin_of_a_long_step() -> None:
    clock, latch = TickClock(SteppedClock(20, lambda _: None)), Latch()
    MaxAgeLayer(clock, 0.5, 3.0, latch).sensor(NullRange(clock), lambda: Range(1.0, 3.0, 0))()
    latch.check()


def test_failed_read_is_repeated() -> None:
    rig = Rig()
    newest = rig.nose._newest

    def raise_once() -> Range:
        rig.nose._newest = newest  # type: ignore[method-assign]
        raise DeviceError("nose", "no echo")

    rig.nose._newest = raise_once  # type: ignore[method-assign]
    with pytest.raises(DeviceError):
        rig.robot.range.read()
    assert rig.robot.range.read().sequence == 1


class Bench:
    """A call monitor layer, and the time limits during the calls of a driver."""

    def __init__(self) -> None:
        self.activity = ActivityMonitor()
        self.layer = CallMonitorLayer(self.activity, 1.0, "rover")
        self.limits: list[TimeLimit | None] = []

    def record(self, *_: object) -> None:
        self.limits.append(self.activity.call)

    def errors(self) -> list[RobotcoreError]:
        assert self.activity.call is None
        return [limit.error(1.5, None) for limit in self.limits if limit]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_call_of_a_device_is_recorded_with_its_name(bench: Bench) -> None:
    inner = NullMotor("left_motor")
    inner.on_command = bench.record
    motor = bench.layer.motor(MotorOutput.from_motor(inner))
    assert motor.set_velocity(99.0) == 12.0
    motor.stop()
    bench.layer.sensor(NullRange(SteppedClock(20, lambda _: None)), bench.record)()  # type: ignore[arg-type]
    errors = [(error.kind, error.device) for error in bench.errors() if isinstance(error, DeviceError)]
    assert errors == [("device-hangs", name) for name in ("left_motor", "left_motor", "nose")]


def test_limit_of_a_sleep_is_its_duration_plus_that_of_a_call(bench: Bench, check_text: CheckText) -> None:
    clock = bench.layer.clock(SteppedClock(20, bench.record))
    clock.now()
    clock.sleep_until(60.0)
    (limit,) = bench.limits
    assert limit
    assert limit.limit_s == 61.0
    check_text(bench.errors()[0])


@pytest.mark.parametrize("error", [EOFError(), ConnectionResetError("reset by peer")])
def test_broken_connection_during_a_sleep_is_a_backend_error(bench: Bench, error: Exception, raises: Raises) -> None:
    def fail(steps: int) -> None:
        raise error

    with raises(BackendError, "connection-broken"):
        bench.layer.clock(SteppedClock(20, fail)).sleep_until(1.0)
