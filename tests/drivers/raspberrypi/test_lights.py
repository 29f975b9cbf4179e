"""Lights on mock pins."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest
from gpiozero.pins.mock import MockFactory, MockPWMPin

from robotcore.errors import DescriptionError
from robotcore.hal.kind import load_kind
from robotcore.hardware import bind_devices
from robotcore.kinds import Led
from robotcore.kinds.led import LedDescription
from tests.drivers.raspberrypi.mock_pins import build_robot, open_device
from tests.texts import Raises

SINGLE, COLOURS = {"driver": "led", "gpio": 12}, {"driver": "rgb-led", "red": 16, "green": 20, "blue": 21}


def describe_lamp(*, is_rgb: bool) -> LedDescription:
    return LedDescription(kind="led", name="lamp", is_rgb=is_rgb)


def open_lamp(table: Mapping[str, Any], pins: MockFactory, *, is_rgb: bool) -> Led:
    lamp = open_device(describe_lamp(is_rgb=is_rgb), table, pins)
    assert isinstance(lamp, Led)
    return lamp


@pytest.fixture
def pins() -> MockFactory:
    return MockFactory(pin_class=MockPWMPin)


def test_brightness_is_the_duty_of_the_pin(pins: MockFactory) -> None:
    lamp = open_lamp(SINGLE, pins, is_rgb=False)
    lamp.set_brightness(0.25)
    assert pins.pin(12).state == 0.25
    lamp.set_colour(0.1, 0.5, 0.2)
    assert pins.pin(12).state == 0.5


def test_each_colour_is_the_duty_of_its_pin(pins: MockFactory) -> None:
    lamp = open_lamp(COLOURS, pins, is_rgb=True)
    lamp.set_colour(1.0, 0.5, 0.0)
    assert [pins.pin(number).state for number in (16, 20, 21)] == [1.0, 0.5, 0.0]


@pytest.mark.parametrize("section, off", [(SINGLE, 0.0), ({**SINGLE, "active_high": False}, 1.0)])
def test_light_is_off_at_first_and_after_closing(pins: MockFactory, section: Mapping[str, Any], off: float) -> None:
    lamp, line = open_lamp(section, pins, is_rgb=False), pins.pin(12)
    assert line.state == off
    lamp.set_brightness(1.0)
    states = [line.state]
    lamp.stop()
    states.append(line.state)
    lamp.close()
    assert states == [1.0 - off, off]
    assert (line.function, line.pull) == ("input", "up" if off else "down")


@pytest.mark.parametrize("section, is_rgb", [(SINGLE, True), (COLOURS, False)])
def test_driver_for_the_other_number_of_colours_is_refused(
    raises: Raises, section: Mapping[str, Any], *, is_rgb: bool
) -> None:
    with raises(DescriptionError, "setting-conflict", key="raspberrypi.lamp"):
        bind_devices(build_robot(describe_lamp(is_rgb=is_rgb), section), "raspberrypi")


def test_kind_of_a_light_needs_no_table() -> None:
    assert load_kind("led").is_optional
