"""Servos on mock pins, and with a double of lgpio."""

from __future__ import annotations

import sys
from types import SimpleNamespace
from typing import Any

import pytest
from gpiozero.pins.mock import MockFactory, MockPWMPin

from robotcore.errors import DescriptionError, InvalidCommandError
from robotcore.hardware import bind_devices
from robotcore.kinds import Servo
from robotcore.kinds.servo import ServoDescription
from tests.drivers.raspberrypi.mock_pins import build_robot, open_device
from tests.texts import Raises

TABLE = {"driver": "servo", "gpio": 12}


LIMITS = {"min_angle_rad": -1.0, "max_angle_rad": 1.0, "max_velocity_rad_s": 5.0}
PAN = ServoDescription.model_validate({"kind": "servo", "name": "pan", **LIMITS})


def open_servo(pins: MockFactory, **settings: float) -> Servo:
    servo = open_device(PAN, {**TABLE, **settings}, pins)
    assert isinstance(servo, Servo)
    return servo


@pytest.fixture
def pins() -> MockFactory:
    return MockFactory(pin_class=MockPWMPin)


def read_pulse_ms(pins: MockFactory) -> float:
    pin = pins.pin(12)
    return float(1000 * pin.state / pin.frequency)


def test_opened_servo_turns_to_its_rest_angle(pins: MockFactory) -> None:
    servo = open_servo(pins)
    assert (servo.angle, read_pulse_ms(pins)) == pytest.approx((0.0, 1.5))


@pytest.mark.parametrize("rad, milliseconds", [(-1.0, 1.0), (0.5, 1.75), (3.0, 2.0)])
def test_angle_is_the_width_of_the_pulse(pins: MockFactory, rad: float, milliseconds: float) -> None:
    servo = open_servo(pins)
    servo.set_angle(rad)
    assert read_pulse_ms(pins) == pytest.approx(milliseconds)


def test_widths_of_the_pulses_are_settings_and_may_be_reversed(pins: MockFactory) -> None:
    servo = open_servo(pins, min_pulse_s=0.0025, max_pulse_s=0.0005)
    widths = []
    for rad in (-1.0, 0.0, 1.0):
        servo.set_angle(rad)
        widths.append(read_pulse_ms(pins))
    assert widths == pytest.approx([2.5, 1.5, 0.5])


def test_refused_angle_changes_no_pulse(pins: MockFactory) -> None:
    servo = open_servo(pins)
    servo.set_angle(0.5)
    with pytest.raises(InvalidCommandError):
        servo.set_angle(float("nan"))
    assert read_pulse_ms(pins) == pytest.approx(1.75)


def test_stopped_servo_holds_and_a_closed_one_gets_no_pulses(pins: MockFactory) -> None:
    servo = open_servo(pins)
    servo.set_angle(0.5)
    servo.stop()
    assert read_pulse_ms(pins) == pytest.approx(1.75)
    servo.close()
    pin = pins.pin(12)
    assert (pin.function, pin.frequency, pin.pull) == ("input", None, "down")


def test_lgpio_gets_fractions_of_a_percent(monkeypatch: pytest.MonkeyPatch) -> None:
    sent: list[Any] = []
    monkeypatch.setitem(sys.modules, "lgpio", SimpleNamespace(tx_pwm=lambda *args: sent.append(args)))
    pins = MockFactory(pin_class=MockPWMPin)
    pins._handle = 7
    open_servo(pins).set_angle(0.11)
    assert sent == [(7, 12, 50, pytest.approx(7.5)), (7, 12, 50, pytest.approx(7.775))]


def test_equal_widths_of_the_pulses_are_refused(raises: Raises) -> None:
    with raises(DescriptionError, "setting-conflict", key="raspberrypi.pan"):
        bind_devices(build_robot(PAN, {**TABLE, "min_pulse_s": 0.002}), "raspberrypi")


@pytest.mark.parametrize("width", [560, 0.56])
def test_width_of_a_pulse_in_another_unit_is_refused(width: float, raises: Raises) -> None:
    with raises(DescriptionError, "out-of-bounds", key="raspberrypi.pan.min_pulse_s"):
        bind_devices(build_robot(PAN, {**TABLE, "min_pulse_s": width}), "raspberrypi")
