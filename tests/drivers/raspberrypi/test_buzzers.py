"""A buzzer on a mock pin."""

from __future__ import annotations

import math
from typing import Any

import pytest
from gpiozero.pins.mock import MockFactory, MockPWMPin

from robotcore.errors import DescriptionError, InvalidCommandError
from robotcore.hardware import bind_devices
from robotcore.kinds.buzzer import BuzzerDescription
from tests.drivers.raspberrypi.mock_pins import build_robot, open_device
from tests.texts import Raises

TABLE = {"driver": "buzzer", "gpio": 12}


def describe_horn(max_frequency_hz: float = 5000.0) -> BuzzerDescription:
    return BuzzerDescription(kind="buzzer", name="horn", max_frequency_hz=max_frequency_hz)


@pytest.fixture
def pins() -> MockFactory:
    return MockFactory(pin_class=MockPWMPin)


@pytest.fixture
def horn(pins: MockFactory) -> Any:
    return open_device(describe_horn(), TABLE, pins)


def test_tone_is_the_frequency_of_the_pin(pins: MockFactory, horn: Any) -> None:
    pin = pins.pin(12)
    assert pin.state == 0
    assert horn.play(440.0) == 440.0
    assert (pin.frequency, pin.state) == (440, 0.5)
    horn.play(0.0)
    assert pin.state == 0


def test_closed_buzzer_is_silent(pins: MockFactory, horn: Any) -> None:
    horn.play(440.0)
    horn.close()
    assert (pins.pin(12).function, pins.pin(12).pull) == ("input", "down")


@pytest.mark.parametrize("frequency", [math.nan, math.inf, -1.0])
def test_frequency_without_a_meaning_is_refused(pins: MockFactory, horn: Any, frequency: float) -> None:
    horn.play(440.0)
    with pytest.raises(InvalidCommandError):
        horn.play(frequency)
    assert pins.pin(12).frequency == 440


@pytest.mark.parametrize("frequency, sent", [(1.0, 20.0), (9000.0, 5000.0)])
def test_frequency_is_limited(horn: Any, frequency: float, sent: float) -> None:
    assert horn.play(frequency) == sent


def test_frequency_that_no_pin_reaches_is_refused(raises: Raises) -> None:
    with raises(DescriptionError, "setting-conflict", key="raspberrypi.horn"):
        bind_devices(build_robot(describe_horn(12_000.0), TABLE), "raspberrypi")
