from __future__ import annotations

from contextlib import closing
from typing import Any, cast

import pytest

from robotcore.errors import DeviceError
from robotcore.kinds.range_sensor import RangeSensor
from tests.system.guest.bench import open_device, wait_until
from tests.system.guest.chip import Chip
from tests.system.guest.models import ECHO, echo_module

UNANSWERED, STUCK = "trigger-unanswered", "echo-stuck"


def open_nose(pins: Any) -> RangeSensor:
    return cast("RangeSensor", open_device("nose", pins))


@pytest.mark.parametrize("distance", [1.0, 2.5])
def test_an_echo_gives_its_distance(chip: Chip, pins: Any, distance: float) -> None:
    """Some echoes are too long, because driver and module are programs on an emulated processor."""
    with echo_module(chip, distance), closing(open_nose(pins)) as nose:
        assert wait_until(lambda: abs(nose.read().distance - distance) < 0.3, expected=True)


def test_each_echo_is_a_new_sample(chip: Chip, pins: Any) -> None:
    with echo_module(chip, 1.0), closing(open_nose(pins)) as nose:
        first = nose.read()
        assert wait_until(lambda: nose.read().sequence >= first.sequence + 2, expected=True)
        assert nose.read().time > first.time


def test_a_module_that_never_answers_makes_opening_raise(pins: Any) -> None:
    with pytest.raises(DeviceError) as raised:
        open_nose(pins)
    assert raised.value.kind == UNANSWERED


def test_reading_raises_if_the_module_stops_answering(chip: Chip, pins: Any) -> None:
    with echo_module(chip, 1.0):
        nose = open_nose(pins)
    with closing(nose):
        assert wait_until(lambda: failure_of(nose), UNANSWERED) == UNANSWERED


def test_reading_raises_while_the_echo_line_stays_high(chip: Chip, pins: Any) -> None:
    with echo_module(chip, 1.0):
        nose = open_nose(pins)
    with closing(nose):
        chip.pull(ECHO, 1)
        assert wait_until(lambda: failure_of(nose), STUCK) == STUCK


def test_reading_works_again_when_the_module_answers_again(chip: Chip, pins: Any) -> None:
    with echo_module(chip, 1.0):
        nose = open_nose(pins)
    with closing(nose):
        wait_until(lambda: failure_of(nose), UNANSWERED)
        with echo_module(chip, 2.0):
            assert wait_until(lambda: failure_of(nose), "") == ""


def failure_of(nose: RangeSensor) -> str:
    """Return the kind of the error that reading raises; an empty text if reading works."""
    try:
        nose.read()
    except DeviceError as error:
        return error.kind
    return ""
