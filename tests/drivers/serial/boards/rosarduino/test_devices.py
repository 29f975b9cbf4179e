from __future__ import annotations

import math

import pytest

from drivers.serial.boards.rosarduino.devices import Pings, Ranges, WheelCounter
from robotcore.description import load_robot
from robotcore.errors import DeviceError
from robotcore.hardware.polled_samples import RangeSampler
from robotcore.kinds.range_sensor import Range, RangeSensorDescription
from tests.texts import Raises

NOSE = load_robot("rover").first_of(RangeSensorDescription)
assert NOSE


def sum_counts(*counts: tuple[float, int]) -> float | None:
    """Return the total after these counts at their times."""
    wheel = WheelCounter()
    for time, count in counts:
        wheel.take(count, time)
    angle = wheel.angle(1.0)
    return angle.angle if angle else None


def test_counts_are_added_up() -> None:
    for counts, turned in [
        ([(0.0, 7)], 0),
        ([(0.0, 7), (0.01, 30)], 23),
        ([(0.0, 2**31 - 1), (0.01, -(2**31) + 4)], 5),
        ([(0.0, -(2**31)), (0.01, 2**31 - 5)], -5),
        ([(0.0, 1234), (0.005, 134), (0.01, 1236)], 2),
        ([(0.0, 1234), (0.005, 134)], 0),
        ([(0.0, 1234), (0.01, 1240), (0.3, 2), (0.31, 9)], 13),
        ([(0.0, 1234), (0.3, 1300)], 66),
        ([(0.0, 100_000), (0.01, 20), (0.02, 25)], 0),
        ([(0.0, 100_000), (0.01, 20), (0.02, 25), (0.03, 30)], 5),
    ]:
        assert sum_counts(*counts) == turned, counts


@pytest.fixture
def sampler() -> RangeSampler:
    assert NOSE
    return RangeSampler(NOSE, echo_free_cycles=3)


@pytest.fixture
def ranges(sampler: RangeSampler) -> Ranges:
    return Ranges("nose", sampler)


@pytest.fixture
def pings(sampler: RangeSampler) -> Pings:
    assert NOSE
    return Pings(NOSE, sampler)


def test_a_range_has_the_age_that_the_board_sends_and_is_one_sample(ranges: Ranges, sampler: RangeSampler) -> None:
    ranges.take((830, 24), 10.0)
    assert sampler.newest.get() == Range(0.83, 10.0 - 0.024, 0)
    ranges.take((830, 56), 10.03)
    assert sampler.newest.get().sequence == 0
    ranges.take((831, 6), 10.06)
    assert sampler.newest.get().sequence == 1


def test_several_cycles_without_an_echo_are_nothing_in_range(ranges: Ranges, sampler: RangeSampler) -> None:
    ranges.take((830, 0), 10.0)
    for cycle in (1, 2):
        ranges.take((-1, 0), 10.0 + 0.06 * cycle)
    assert sampler.newest.get().distance == 0.83
    ranges.take((-1, 0), 10.18)
    assert sampler.newest.get().distance == math.inf


@pytest.mark.parametrize("reply", [(-1, 65535), (830, 501)])
def test_a_module_that_does_not_answer_is_an_error(
    ranges: Ranges, sampler: RangeSampler, reply: tuple[int, int], raises: Raises
) -> None:
    ranges.take(reply, 70.0)
    with raises(DeviceError, "module-silent", device="nose"):
        sampler.newest.get()
    ranges.take((830, 0), 71.0)
    assert sampler.newest.get().distance == 0.83


def test_pings_are_in_centimetres_and_several_beyond_the_maximum_are_nothing_in_range(
    pings: Pings, sampler: RangeSampler
) -> None:
    pings.take((52,), 10.0)
    assert sampler.newest.get() == Range(0.52, 10.0, 0)
    for cycle in range(3):
        assert sampler.newest.get().distance == 0.52
        pings.take((655,), 11.0 + cycle)
    assert sampler.newest.get().distance == math.inf


def test_several_pings_without_a_pulse_are_an_error(pings: Pings, sampler: RangeSampler, raises: Raises) -> None:
    for cycle in range(3):
        assert not sampler.has_result
        pings.take((0,), 10.0 + cycle)
    with raises(DeviceError, "module-silent", device="nose"):
        sampler.newest.get()
    pings.take((52,), 14.0)
    assert sampler.newest.get().distance == 0.52
