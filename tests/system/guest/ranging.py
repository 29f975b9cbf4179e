from __future__ import annotations

from contextlib import closing
from typing import Any, cast

import pytest

from robotcore.errors import DeviceError
from robotcore.hal.devices import RangeSensor
from tests.system.guest.bench import open_device, settled
from tests.system.guest.chip import Chip
from tests.system.guest.models import ECHO, answering


def opened(pins: Any) -> RangeSensor:
    return cast("RangeSensor", open_device("nose", pins))


@pytest.mark.parametrize("distance", [1.0, 2.5])
def test_an_echo_tells_how_far_it_came(chip: Chip, pins: Any, distance: float) -> None:
    """Some echoes seem to come from farther away: both sides of them are programs on an emulated processor."""
    with answering(chip, distance), closing(opened(pins)) as nose:
        assert settled(lambda: abs(nose.read().distance - distance) < 0.3, expected=True)


def test_each_echo_is_a_new_sample(chip: Chip, pins: Any) -> None:
    with answering(chip, 1.0), closing(opened(pins)) as nose:
        first = nose.read()
        assert settled(lambda: nose.read().sequence >= first.sequence + 2, expected=True)
        assert nose.read().time > first.time


def test_a_module_that_never_answers_is_named_when_it_is_opened(pins: Any) -> None:
    with pytest.raises(DeviceError, match=r"^nose: does not answer its trigger"):
        opened(pins)


def test_a_module_that_falls_silent_is_named_and_no_sample_is_made_up(chip: Chip, pins: Any) -> None:
    with answering(chip, 1.0):
        nose = opened(pins)
    with closing(nose):
        assert settled(lambda: said(nose), "does not answer") == "does not answer"


def test_an_echo_line_that_stays_high_is_named(chip: Chip, pins: Any) -> None:
    with answering(chip, 1.0):
        nose = opened(pins)
    with closing(nose):
        chip.pull(ECHO, 1)
        assert settled(lambda: said(nose), "its echo stays high") == "its echo stays high"


def test_it_is_heard_again_when_it_answers_again(chip: Chip, pins: Any) -> None:
    with answering(chip, 1.0):
        nose = opened(pins)
    with closing(nose):
        settled(lambda: said(nose), "does not answer")
        with answering(chip, 2.0):
            assert settled(lambda: said(nose), "a distance") == "a distance"


def said(nose: RangeSensor) -> str:
    """Return what reading comes to, in two or three words."""
    try:
        nose.read()
    except DeviceError as error:
        return next(words for words in ("does not answer", "its echo stays high", str(error)) if words in str(error))
    return "a distance"
