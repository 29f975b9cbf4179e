"""What is polled beside the app, handed out."""

from __future__ import annotations

import math

import pytest

from robotcore.description import RangeSensorDescription, load_robot
from robotcore.errors import DeviceError
from robotcore.hal.devices import Range
from robotcore.hardware import Newest
from robotcore.hardware.polled import Findings

FIRST, SECOND = Range(1.0, time=0.0, sequence=0), Range(0.9, time=0.1, sequence=1)


@pytest.fixture
def newest() -> Newest[Range]:
    return Newest("nose", FIRST)


def test_the_last_sample_is_handed_out_until_there_is_a_newer_one(newest: Newest[Range]) -> None:
    assert newest.get() is newest.get() is FIRST
    newest.put(SECOND)
    assert newest.get() is SECOND


def test_a_failure_is_told_by_the_device_s_name_for_as_long_as_it_lasts(newest: Newest[Range]) -> None:
    newest.fail(OSError("no answer"))
    for _ in range(2):
        with pytest.raises(DeviceError, match="nose: OSError: no answer") as caught:
            newest.get()
        assert isinstance(caught.value.__cause__, OSError)


def test_a_named_failure_stays_as_it_is(newest: Newest[Range]) -> None:
    error = DeviceError("nose", "is gone; plug it in again")
    newest.fail(error)
    with pytest.raises(DeviceError) as caught:
        newest.get()
    assert caught.value is error


def test_a_device_that_works_again_is_read_again(newest: Newest[Range]) -> None:
    newest.fail(OSError("no answer"))
    newest.put(SECOND)
    assert newest.get() is SECOND


[NOSE] = load_robot("rover").all_of(RangeSensorDescription)


def test_before_anything_was_found_it_says_so() -> None:
    findings = Findings(NOSE, 3)
    findings.nothing(0.0)
    findings.recovered()
    assert not findings.has_told
    with pytest.raises(DeviceError, match="nose: has found nothing that could be judged"):
        findings.newest.get()


def test_a_failure_ends_a_row_of_nothing() -> None:
    findings = Findings(NOSE, 3)
    findings.found(1.0, 0.0)
    findings.nothing(0.1)
    findings.nothing(0.2)
    findings.failed(OSError("unplugged"))
    findings.recovered()
    findings.nothing(0.3)
    assert findings.newest.get().time == 0.0


def test_what_is_in_range_and_what_is_not() -> None:
    findings = Findings(NOSE, 3)
    for number, (distance, told) in enumerate([(0.0, 0.02), (0.5, 0.5), (2.0, 2.0), (2.001, math.inf)]):
        findings.found(distance, float(number))
        sample = findings.newest.get()
        assert (sample.distance, sample.time, sample.sequence) == (told, float(number), number)
