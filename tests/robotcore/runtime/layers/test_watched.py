from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore.errors import BackendError, DeviceError
from robotcore.hal.clock import SteppedClock
from robotcore.runtime.layers.checks import Watched
from robotcore.safety import Stay, Whereabouts
from tests.robotcore.fakes import NullMotor, NullRange


class Bench:
    """The layer, and what it noted in the middle of a driver's call."""

    def __init__(self) -> None:
        self.where = Whereabouts()
        self.layer = Watched(self.where, 1.0, "rover")
        self.noted: list[Stay | None] = []

    def note(self, *_: object) -> None:
        self.noted.append(self.where.call)

    def errors(self) -> list[str]:
        assert self.where.call is None
        return [str(stay.error(1.5, None)) for stay in self.noted if stay]


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_a_motor_is_named_while_it_is_told_or_stopped(bench: Bench) -> None:
    inner = NullMotor("left_motor")
    inner.on_command = bench.note
    motor = bench.layer.motor(inner)
    assert motor.set_velocity(99.0) == 12.0
    motor.stop()
    assert [error.partition(".")[0] for error in bench.errors()] == ["left_motor: has not answered for 1"] * 2


def test_a_sensor_is_named_while_it_is_read(bench: Bench) -> None:
    nose = NullRange(SteppedClock(20, lambda _: None))
    read = nose.read

    def noting() -> object:
        bench.note()
        return read()

    bench.layer.sensor(nose, noting)()  # type: ignore[arg-type]
    (error,) = bench.errors()
    assert error.startswith("nose: has not answered for 1.5 s")


def test_nothing_is_noted_any_more_when_a_driver_raises(bench: Bench) -> None:
    inner = NullMotor("left_motor")
    inner.is_broken = True
    with pytest.raises(DeviceError):
        bench.layer.motor(inner).set_velocity(1.0)
    assert bench.where.call is None


def test_a_sleep_may_take_as_long_as_it_was_to_take_and_a_call_longer(bench: Bench) -> None:
    clock = bench.layer.clock(SteppedClock(20, bench.note))
    clock.now()
    clock.sleep_until(60.0)
    (stay,) = bench.noted
    assert stay
    assert stay.limit_s == 61.0
    assert bench.errors()[0].startswith("the backend of 'rover' has not answered for 1.5 s, while time was to pass")


@pytest.mark.parametrize("error", [EOFError(), ConnectionResetError("reset by peer")])
def test_a_connection_that_breaks_while_time_is_to_pass_is_the_backends_error(bench: Bench, error: Exception) -> None:
    def fail(steps: int) -> None:
        raise error

    with pytest.raises(BackendError, match=f"no time pass: {type(error).__name__}"):
        bench.layer.clock(SteppedClock(20, fail)).sleep_until(1.0)


def test_a_device_that_fails_while_time_passes_is_told_as_it_is(bench: Bench) -> None:
    def fail(steps: int) -> None:
        raise DeviceError("left_motor", "no current")

    with pytest.raises(DeviceError, match="left_motor: no current"):
        bench.layer.clock(SteppedClock(20, fail)).sleep_until(1.0)


def test_calls_are_made_by_the_clock_below(bench: Bench) -> None:
    called: list[float] = []
    inner = SteppedClock(20, lambda _: None)
    call: Callable[[], None] = lambda: called.append(inner.now())  # noqa: E731
    clock = bench.layer.clock(inner)
    clock.call_at(0.1, call)
    clock.sleep_until(1.0)
    assert called == [pytest.approx(0.1)]
