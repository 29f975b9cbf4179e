from __future__ import annotations

from collections.abc import Callable

import pytest

from robotcore.errors import DeviceError, StaleSampleError
from robotcore.hal.clock import SteppedClock, TickClock
from robotcore.hal.devices import Range
from robotcore.runtime.layers.base import OnceATick
from robotcore.runtime.layers.checks import Fresh
from robotcore.safety import Latch


@pytest.fixture
def clock() -> TickClock:
    return TickClock(SteppedClock(20, lambda _: None))


def counting() -> Callable[[], Range]:
    samples = (Range(1.0, 0.0, sequence) for sequence in range(100))
    return lambda: next(samples)


def test_within_a_tick_the_sample_is_one(clock: TickClock) -> None:
    read = OnceATick(clock, counting())
    assert read() is read()
    clock.sleep_until(0.05)
    assert read().sequence == 1


def test_a_tick_without_a_read_takes_no_sample(clock: TickClock) -> None:
    read = OnceATick(clock, counting())
    for tick in range(1, 5):
        clock.sleep_until(tick / 20)
    assert read().sequence == 0


def test_the_latest_can_be_looked_at_without_reading(clock: TickClock) -> None:
    read = OnceATick(clock, counting())
    assert read.latest is None
    sample = read()
    clock.sleep_until(0.05)
    assert read.latest is sample


def test_a_read_that_failed_is_tried_again(clock: TickClock) -> None:
    outcomes: list[DeviceError | Range] = [DeviceError("nose", "no echo"), Range(1.0, 0.0, 0)]

    def read() -> Range:
        outcome = outcomes.pop(0)
        if isinstance(outcome, DeviceError):
            raise outcome
        return outcome

    once = OnceATick(clock, read)
    with pytest.raises(DeviceError):
        once()
    assert once().distance == 1.0


def test_a_sample_of_just_the_limit_is_fresh_enough(clock: TickClock) -> None:
    clock.sleep_until(0.5)
    assert Fresh("nose", clock, 0.5, Latch(), lambda: Range(1.0, 0.0, 0))().sequence == 0


def test_an_older_sample_is_refused_by_name_and_age(clock: TickClock) -> None:
    clock.sleep_until(0.55)
    with pytest.raises(StaleSampleError, match="nose") as raised:
        Fresh("nose", clock, 0.5, Latch(), lambda: Range(1.0, 0.0, 0))()
    assert raised.value.age == pytest.approx(0.55)
    assert raised.value.limit == 0.5


def test_an_older_sample_ends_the_run_though_the_app_swallows_it(clock: TickClock) -> None:
    clock.sleep_until(0.55)
    latch = Latch()
    latch.check()
    with pytest.raises(StaleSampleError):
        Fresh("nose", clock, 0.5, latch, lambda: Range(1.0, 0.0, 0))()
    with pytest.raises(StaleSampleError, match="nose"):
        latch.check()
