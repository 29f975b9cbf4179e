"""Servos on a PCA9685 on a simulated bus."""

from __future__ import annotations

from typing import Any

import pytest

from drivers.raspberrypi.pwm.servos import ChannelServoDriver
from robotcore.errors import DescriptionError, DeviceError
from robotcore.hardware import bind_devices
from robotcore.kinds import Servo
from tests.drivers.raspberrypi.i2c_dev import Bus
from tests.drivers.raspberrypi.pwm.robots import PAN, build_context, build_robot, open_devices
from tests.texts import CheckText, Raises

COUNT_S = 122 / 25e6
ON_BOARD = {"driver": "pca9685-servo", "board": "freenove-4wd", "channel": 8}


def open_servo(**settings: float) -> Servo:
    robot = build_robot(pan={**PAN, **settings})
    (servo,) = open_devices(robot, build_context(robot))
    assert isinstance(servo, Servo)
    return servo


def read_pulse_s(bus: Bus) -> float:
    assert bus.registers[0xFE] == 121
    return bus.duties()[15] * 4096 * COUNT_S


def test_angle_is_the_width_of_the_pulse_to_5_microseconds(bus: Bus) -> None:
    servo = open_servo()
    assert read_pulse_s(bus) == pytest.approx(0.0015, abs=3e-6)
    for rad, width in ((-1.0, 0.001), (0.5, 0.00175), (3.0, 0.002)):
        servo.set_angle(rad)
        assert read_pulse_s(bus) == pytest.approx(width, abs=3e-6)


def test_widths_may_be_reversed_and_a_closed_servo_gets_no_pulses(bus: Bus) -> None:
    servo = open_servo(min_pulse_s=0.0025, max_pulse_s=0.0005)
    servo.set_angle(1.0)
    assert read_pulse_s(bus) == pytest.approx(0.0005, abs=3e-6)
    servo.close()
    assert bus.duties()[15] == 0.0


def test_unplugged_chip_is_an_error_with_its_address(bus: Bus, raises: Raises) -> None:
    servo = open_servo()
    bus.unplug()
    with raises(DeviceError, "chip-unanswered"):
        servo.set_angle(0.5)


def test_equal_widths_are_refused(raises: Raises) -> None:
    with raises(DescriptionError, "setting-conflict"):
        bind_devices(build_robot(pan={**PAN, "min_pulse_s": 0.002}), "raspberrypi")


def test_board_gives_the_address_unless_the_table_has_one() -> None:
    for table, address in ((ON_BOARD, 0x40), ({**ON_BOARD, "address": 0x41}, 0x41)):
        (binding,) = bind_devices(build_robot(pan=table), "raspberrypi")
        assert isinstance(binding.driver, ChannelServoDriver)
        assert binding.driver.address == address


@pytest.mark.parametrize(
    "table, kind",
    [
        ({**ON_BOARD, "board": ["freenove-4wd"]}, "unknown-board"),
        ({**ON_BOARD, "channel": 7}, "unknown-servo"),
        ({**ON_BOARD, "board": "adafruit-motor-hat"}, "unknown-servo"),
    ],
    ids=["list", "channel", "board without servos"],
)
def test_servo_that_a_board_lacks_is_refused(table: dict[str, Any], kind: str, raises: Raises) -> None:
    with raises(DescriptionError, kind):
        bind_devices(build_robot(pan=table), "raspberrypi")


@pytest.mark.parametrize("table", [PAN, ON_BOARD], ids=["chip", "board"])
def test_notes_name_the_supplies(table: dict[str, Any], check_text: CheckText) -> None:
    (binding,) = bind_devices(build_robot(pan=table), "raspberrypi")
    check_text("\n".join(binding.notes))
