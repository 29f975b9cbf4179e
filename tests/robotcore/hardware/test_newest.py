"""What is polled beside the app, handed out."""

from __future__ import annotations

import pytest

from robotcore.errors import DeviceError
from robotcore.hal.devices import Range
from robotcore.hardware import Newest

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
