from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore.errors import BackendError, DeviceError, RobotcoreError, StaleSampleError
from robotcore.hal.clock import SteppedClock, TickClock
from robotcore.hal.devices import Range
from robotcore.runtime.layers.base import MotorOutput
from robotcore.runtime.layers.checks import CallMonitorLayer, MaxAgeReader
from robotcore.runtime.layers.devices import AppSensor, wrap_sensor
from robotcore.safety import ActivityMonitor, Latch, TimeLimit
from tests.robotcore.fakes import NullMotor, NullRange
from tests.texts import CheckText, Raises


@pytest.fixture
def clock() -> TickClock:
    return TickClock(SteppedClock(20, lambda _: None))


def counting() -> Callable[[], Range]:
    samples = (Range(1.0, 0.0, sequence) for sequence in range(100))
    return lambda: next(samples)


def layered(clock: TickClock, read: Callable[[], Range]) -> AppSensor[Range]:
    sensor = wrap_sensor(NullRange(clock), clock, read)
    assert isinstance(sensor, AppSensor)
    return sensor


def test_within_a_tick_the_sample_is_one(clock: TickClock) -> None:
    read = layered(clock, counting())
    assert read.read() is read.read()
    clock.sleep_until(0.05)
    assert read.read().sequence == 1


def test_a_tick_without_a_read_takes_no_sample(clock: TickClock) -> None:
    read = layered(clock, counting())
    for tick in range(1, 5):
        clock.sleep_until(tick / 20)
    assert read.read().sequence == 0


def test_the_latest_can_be_looked_at_without_reading(clock: TickClock) -> None:
    read = layered(clock, counting())
    assert read.latest is None
    sample = read.read()
    clock.sleep_until(0.05)
    assert read.latest is sample


def test_a_read_that_failed_is_tried_again(clock: TickClock) -> None:
    outcomes: list[DeviceError | Range] = [DeviceError("nose", "no echo"), Range(1.0, 0.0, 0)]

    def read() -> Range:
        outcome = outcomes.pop(0)
        if isinstance(outcome, DeviceError):
            raise outcome
        return outcome

    once = layered(clock, read)
    with pytest.raises(DeviceError):
        once.read()
    assert once.read().distance == 1.0


def test_a_sample_of_just_the_limit_is_fresh_enough(clock: TickClock) -> None:
    clock.sleep_until(0.5)
    assert MaxAgeReader("nose", clock, 0.5, Latch(), lambda: Range(1.0, 0.0, 0))().sequence == 0


def test_an_older_sample_is_refused_by_name_and_age(clock: TickClock) -> None:
    clock.sleep_until(0.55)
    with pytest.raises(StaleSampleError) as raised:
        MaxAgeReader("nose", clock, 0.5, Latch(), lambda: Range(1.0, 0.0, 0))()
    assert raised.value.age == pytest.approx(0.55)
    assert raised.value.limit == 0.5


def test_an_older_sample_ends_the_run_though_the_app_swallows_it(clock: TickClock) -> None:
    clock.sleep_until(0.55)
    latch = Latch()
    latch.check()
    with pytest.raises(StaleSampleError):
        MaxAgeReader("nose", clock, 0.5, latch, lambda: Range(1.0, 0.0, 0))()
    with pytest.raises(StaleSampleError):
        latch.check()


class Bench:
    """The layer, and what it noted in the middle of a driver's call."""

    def __init__(self) -> None:
        self.activity = ActivityMonitor()
        self.layer = CallMonitorLayer(self.activity, 1.0, "rover")
        self.noted: list[TimeLimit | None] = []

    def note(self, *_: object) -> None:
        self.noted.append(self.activity.call)

    def errors(self) -> list[RobotcoreError]:
        assert self.activity.call is None
        return [limit.error(1.5, None) for limit in self.noted if limit]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_motor_is_named_while_it_is_reported_or_stopped(bench: Bench) -> None:
    inner = NullMotor("left_motor")
    inner.on_command = bench.note
    motor = bench.layer.motor(MotorOutput.of(inner))
    assert motor.set_velocity(99.0) == 12.0
    motor.stop()
    assert [(error.kind, error.device) for error in bench.errors() if isinstance(error, DeviceError)] == [
        ("device-hangs", "left_motor")
    ] * 2


def test_a_sensor_is_named_while_it_is_read(bench: Bench) -> None:
    nose = NullRange(SteppedClock(20, lambda _: None))
    read = nose.read

    def noting() -> object:
        bench.note()
        return read()

    bench.layer.sensor(nose, noting)()  # type: ignore[arg-type]
    (error,) = bench.errors()
    assert isinstance(error, DeviceError)
    assert (error.kind, error.device) == ("device-hangs", "nose")


def test_nothing_is_noted_any_more_when_a_driver_raises(bench: Bench) -> None:
    inner = NullMotor("left_motor")
    inner.is_broken = True
    with pytest.raises(DeviceError):
        bench.layer.motor(MotorOutput.of(inner)).set_velocity(1.0)
    assert bench.activity.call is None


def test_a_sleep_may_take_as_long_as_it_was_to_take_and_a_call_longer(bench: Bench, check_text: CheckText) -> None:
    clock = bench.layer.clock(SteppedClock(20, bench.note))
    clock.now()
    clock.sleep_until(60.0)
    (stay,) = bench.noted
    assert stay
    assert stay.limit_s == 61.0
    check_text(bench.errors()[0])


@pytest.mark.parametrize("error", [EOFError(), ConnectionResetError("reset by peer")])
def test_a_connection_that_breaks_while_time_is_to_pass_is_the_backends_error(
    bench: Bench, error: Exception, raises: Raises
) -> None:
    def fail(steps: int) -> None:
        raise error

    with raises(BackendError, "connection-broken"):
        bench.layer.clock(SteppedClock(20, fail)).sleep_until(1.0)


def test_a_device_that_fails_while_time_passes_is_reported_as_it_is(bench: Bench) -> None:
    def fail(steps: int) -> None:
        raise DeviceError("left_motor", "no current")

    with pytest.raises(DeviceError):
        bench.layer.clock(SteppedClock(20, fail)).sleep_until(1.0)


def test_calls_are_made_by_the_clock_below(bench: Bench) -> None:
    called: list[float] = []
    inner = SteppedClock(20, lambda _: None)
    call: Callable[[], None] = lambda: called.append(inner.now())  # noqa: E731
    clock = bench.layer.clock(inner)
    clock.call_at(0.1, call)
    clock.sleep_until(1.0)
    assert called == [pytest.approx(0.1)]
