from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore.errors import BackendError, DeviceError, RobotcoreError, StaleSampleError
from robotcore.hal.clock import SteppedClock, TickClock
from robotcore.hal.devices import Range
from robotcore.runtime.layers.base import MotorOutput
from robotcore.runtime.layers.checks import CallMonitorLayer, MaxAgeLayer
from robotcore.runtime.layers.devices import AppSensor, wrap_sensor
from robotcore.safety import ActivityMonitor, Latch, TimeLimit
from tests.robotcore.fakes import NullMotor, NullRange
from tests.texts import CheckText, Raises


@pytest.fixture
def clock() -> TickClock:
    return TickClock(SteppedClock(20, lambda _: None))


def build_counter() -> Callable[[], Range]:
    samples = (Range(1.0, 0.0, sequence) for sequence in range(100))
    return lambda: next(samples)


def wrap(clock: TickClock, read: Callable[[], Range]) -> AppSensor[Range]:
    sensor = wrap_sensor(NullRange(clock), clock, read)
    assert isinstance(sensor, AppSensor)
    return sensor


def test_failed_read_is_repeated(clock: TickClock) -> None:
    outcomes: list[DeviceError | Range] = [DeviceError("nose", "no echo"), Range(1.0, 0.0, 0)]

    def read() -> Range:
        outcome = outcomes.pop(0)
        if isinstance(outcome, DeviceError):
            raise outcome
        return outcome

    once = wrap(clock, read)
    with pytest.raises(DeviceError):
        once.read()
    assert once.read().distance == 1.0


def read_checked(clock: TickClock, latch: Latch) -> Range:
    """Read a sample that was captured at 0 s. The age limit is 0.5 s."""
    return MaxAgeLayer(clock, 0.5, latch).sensor(NullRange(clock), lambda: Range(1.0, 0.0, 0))()


def test_sample_exactly_at_the_age_limit_is_accepted(clock: TickClock) -> None:
    clock.sleep_until(0.5)
    assert read_checked(clock, Latch()).sequence == 0


def test_older_sample_ends_the_run_even_if_the_app_catches_the_error(clock: TickClock) -> None:
    clock.sleep_until(0.55)
    latch = Latch()
    latch.check()
    with pytest.raises(StaleSampleError) as raised:
        read_checked(clock, latch)
    assert [raised.value.age, raised.value.limit] == pytest.approx([0.55, 0.5])
    with pytest.raises(StaleSampleError):
        latch.check()


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


def test_call_of_a_motor_is_recorded_with_its_name(bench: Bench) -> None:
    inner = NullMotor("left_motor")
    inner.on_command = bench.record
    motor = bench.layer.motor(MotorOutput.of(inner))
    assert motor.set_velocity(99.0) == 12.0
    motor.stop()
    assert [(error.kind, error.device) for error in bench.errors() if isinstance(error, DeviceError)] == [
        ("device-hangs", "left_motor")
    ] * 2


def test_read_of_a_sensor_is_recorded_with_its_name(bench: Bench) -> None:
    nose = NullRange(SteppedClock(20, lambda _: None))
    read = nose.read

    def record_and_read() -> object:
        bench.record()
        return read()

    bench.layer.sensor(nose, record_and_read)()  # type: ignore[arg-type]
    (error,) = bench.errors()
    assert isinstance(error, DeviceError)
    assert (error.kind, error.device) == ("device-hangs", "nose")


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
