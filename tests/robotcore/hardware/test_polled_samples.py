"""Samples of devices that another thread polls."""

from __future__ import annotations

import math

import pytest

from robotcore.description import load_robot
from robotcore.errors import DeviceError
from robotcore.hardware import NewestSample
from robotcore.hardware.polled_samples import RangeSampler
from robotcore.kinds.range_sensor import Range, RangeSensorDescription
from tests.texts import Raises

FIRST, SECOND = Range(1.0, time=0.0, sequence=0), Range(0.9, time=0.1, sequence=1)


@pytest.fixture
def newest() -> NewestSample[Range]:
    return NewestSample("nose", FIRST)


def test_a_failure_is_raised_with_the_device_name_until_the_next_sample(
    newest: NewestSample[Range], raises: Raises
) -> None:
    newest.fail(OSError("no answer"))
    for _ in range(2):
        with raises(DeviceError, "driver-failed", device="nose") as caught:
            newest.get()
        assert isinstance(caught.value.__cause__, OSError)


def test_device_error_is_raised_unchanged(newest: NewestSample[Range]) -> None:
    error = DeviceError("nose", "is gone; plug it in again")
    newest.fail(error)
    with pytest.raises(DeviceError) as caught:
        newest.get()
    assert caught.value is error


[NOSE] = load_robot("rover").all_of(RangeSensorDescription)


def test_reading_before_the_first_result_raises(raises: Raises) -> None:
    sampler = RangeSampler(NOSE, 3)
    sampler.add_no_echo(0.0)
    sampler.clear_failure()
    assert not sampler.has_result
    with raises(DeviceError, "no-sample-yet", device="nose"):
        sampler.newest.get()


def test_failure_resets_the_count_of_missing_echoes() -> None:
    sampler = RangeSampler(NOSE, 3)
    sampler.add_distance(1.0, 0.0)
    sampler.add_no_echo(0.1)
    sampler.add_no_echo(0.2)
    sampler.fail(OSError("unplugged"))
    sampler.clear_failure()
    sampler.add_no_echo(0.3)
    assert sampler.newest.get().time == 0.0


def test_distances_are_limited_to_the_range() -> None:
    sampler = RangeSampler(NOSE, 3)
    for number, (distance, reported) in enumerate([(0.0, 0.02), (0.5, 0.5), (2.0, 2.0), (2.001, math.inf)]):
        sampler.add_distance(distance, float(number))
        sample = sampler.newest.get()
        assert (sample.distance, sample.time, sample.sequence) == (reported, float(number), number)
