"""A buzzer on a mock pin."""

from __future__ import annotations

import math
from typing import Any

import pytest
from gpiozero.pins.mock import MockFactory, MockPWMPin

from robotcore.errors import DescriptionError, InvalidCommandError
from robotcore.hal.clock import SteppedClock
from robotcore.hardware import DeviceBinding, DeviceContext, bind_devices
from robotcore.kinds.buzzer import BuzzerDescription
from tests.drivers.raspberrypi.motors.rig import rover
from tests.texts import Raises

SECTION = {"horn": {"driver": "buzzer", "gpio": 12}}


def bind_horn(max_frequency_hz: float = 5000.0) -> tuple[DeviceBinding, DeviceContext]:
    horn = BuzzerDescription(kind="buzzer", name="horn", max_frequency_hz=max_frequency_hz)
    robot = rover(SECTION).model_copy(update={"devices": (horn,)})
    pins = MockFactory(pin_class=MockPWMPin)
    (binding,) = bind_devices(robot, "raspberrypi")
    return binding, DeviceContext(robot, SteppedClock(20.0, lambda _steps: None), pins)


@pytest.fixture
def context() -> DeviceContext:
    return bind_horn()[1]


@pytest.fixture
def horn(context: DeviceContext) -> Any:
    return bind_horn()[0].open(context)


def test_tone_is_the_frequency_of_the_pin(context: DeviceContext, horn: Any) -> None:
    pin = context.pins.pin(12)
    assert pin.state == 0
    assert horn.play(440.0) == 440.0
    assert (pin.frequency, pin.state) == (440, 0.5)
    horn.play(0.0)
    assert pin.state == 0


def test_closed_buzzer_is_silent(context: DeviceContext, horn: Any) -> None:
    horn.play(440.0)
    horn.close()
    assert context.pins.pin(12).function == "input"


@pytest.mark.parametrize("frequency", [math.nan, math.inf, -1.0])
def test_frequency_without_a_meaning_is_refused(context: DeviceContext, horn: Any, frequency: float) -> None:
    horn.play(440.0)
    with pytest.raises(InvalidCommandError):
        horn.play(frequency)
    assert context.pins.pin(12).frequency == 440


@pytest.mark.parametrize("frequency, sent", [(1.0, 20.0), (9000.0, 5000.0)])
def test_frequency_is_limited(horn: Any, frequency: float, sent: float) -> None:
    assert horn.play(frequency) == sent


def test_frequency_that_no_pin_reaches_is_refused(raises: Raises) -> None:
    with raises(DescriptionError, "setting-conflict", key="raspberrypi.horn"):
        bind_horn(12_000.0)
