"""Motors on a PCA9685 on a simulated bus: boards, duties, stops, mistakes in the robot's file, and failures."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from gpiozero.pins.mock import MockFactory, MockPWMPin

from drivers.raspberrypi.i2c_device import TIMEOUT_S
from robotcore.errors import DescriptionError, DeviceError
from robotcore.hardware import bind_devices
from robotcore.kinds.imu import ImuDescription
from tests.drivers.raspberrypi.i2c_dev import ALL_OFF, Bus
from tests.drivers.raspberrypi.pwm.robots import LEFT, MODEL, PAN, RIGHT, build_context, build_robot, open_devices
from tests.texts import CheckText, Raises

TWO_CHANNELS = {"driver": "pca9685-motor", "address": 0x60, "forward": 0, "backward": 1, "model": MODEL}
PHASE = {"driver": "pca9685-phase-motor", "address": 0x60, "pwm": 4, "phase": 17, "model": MODEL}


def open_motor(table: Mapping[str, Any], **parts: Any) -> Any:
    robot = build_robot(left_motor=table)
    (motor,) = open_devices(robot, build_context(robot, **parts))
    return motor


def find_on(bus: Bus) -> dict[int, float]:
    """Return the duties of the channels that are on."""
    return {channel: duty for channel, duty in enumerate(bus.duties()) if duty}


def test_opened_chip_has_its_frequency_and_every_channel_off(bus: Bus) -> None:
    bus.switch_on()
    assert set(bus.duties()) == {1.0}
    open_motor({**LEFT, "frequency_hz": 400})
    assert (bus.registers[0x00], bus.registers[0x01], bus.registers[0xFE]) == (0x20, 0x04, 14)
    assert find_on(bus) == {}
    assert next(bus.transfers()).register == ALL_OFF


@pytest.mark.parametrize(
    "table, forward, backward",
    [
        (LEFT, {8: 0.5, 9: 1.0}, {8: 0.25, 10: 1.0}),
        (RIGHT, {13: 0.5, 11: 1.0}, {13: 0.25, 12: 1.0}),
        ({**RIGHT, "forward": 12, "backward": 11}, {13: 0.5, 12: 1.0}, {13: 0.25, 11: 1.0}),
        (
            {**LEFT, "board": "waveshare-motor-driver-hat", "motor": "MB", "address": 0x60},
            {5: 0.5, 4: 1.0},
            {5: 0.25, 3: 1.0},
        ),
        (TWO_CHANNELS, {0: 0.5}, {1: 0.25}),
        ({**LEFT, "board": "freenove-4wd", "motor": "rear-left", "address": 0x60}, {3: 0.5}, {2: 0.25}),
    ],
)
def test_velocity_is_the_duty_of_the_channels(
    bus: Bus, table: Mapping[str, Any], forward: dict[int, float], backward: dict[int, float]
) -> None:
    motor = open_motor(table)
    motor.set_velocity(5.0)
    assert find_on(bus) == forward
    motor.set_velocity(-2.5)
    assert find_on(bus) == backward
    motor.stop()
    assert find_on(bus) == {}


def test_full_duty_is_on_without_a_gap_and_every_command_is_sent(bus: Bus) -> None:
    motor = open_motor(TWO_CHANNELS)
    for _ in range(2):
        count = len(list(bus.transfers()))
        motor.set_velocity(10.0)
        assert find_on(bus) == {0: 1.0}
        assert len(list(bus.transfers())) > count


def test_reversal_switches_the_motor_off_first(bus: Bus) -> None:
    motor = open_motor(LEFT)
    motor.set_velocity(5.0)
    before = len(list(bus.transfers()))
    motor.set_velocity(-5.0)
    first = list(bus.transfers())[before]
    assert (first.register, first.values[3]) == (6 + 4 * 8, 0x10)


@pytest.mark.parametrize("forward_is_high", [False, True])
def test_direction_on_a_gpio_changes_while_the_motor_is_off(*, bus: Bus, forward_is_high: bool) -> None:
    pins = MockFactory(pin_class=MockPWMPin)
    motor = open_motor({**PHASE, "forward_is_high": forward_is_high}, pins=pins)
    duties = []
    pin = pins.pin(17)
    set_state = pin._set_state

    def record(value: float) -> None:
        duties.append(find_on(bus))
        set_state(value)

    pin._set_state = record
    motor.set_velocity(5.0)
    assert (pin.state, find_on(bus)) == (forward_is_high, {4: 0.5})
    motor.set_velocity(-5.0)
    assert (pin.state, find_on(bus)) == (not forward_is_high, {4: 0.5})
    assert duties == [{}, {}]
    motor.close()
    assert find_on(bus) == {}
    assert pin.function == "input"


def test_motors_share_a_chip_and_stop_each_on_its_own(bus: Bus) -> None:
    robot = build_robot(left_motor=LEFT, right_motor=RIGHT)
    context = build_context(robot)
    left, right = open_devices(robot, context)
    left.set_velocity(5.0)
    right.set_velocity(5.0)
    left.close()
    assert find_on(bus) == {13: 0.5, 11: 1.0}
    context.shared.close()
    assert find_on(bus) == {}


def test_motor_that_does_not_answer_names_the_bus_and_what_to_do(bus: Bus, raises: Raises) -> None:
    robot = build_robot(left_motor=LEFT, right_motor=RIGHT)
    motors = open_devices(robot, build_context(robot))
    bus.unplug()
    for motor in motors:
        with raises(DeviceError, "chip-unanswered"):
            motor.set_velocity(5.0)


@pytest.mark.parametrize("error, channels", [(OSError, (8, 10, 9)), (TimeoutError, (8,))], ids=["failure", "hung bus"])
def test_failed_stop_is_tried_at_each_channel_unless_the_bus_hangs(
    bus: Bus, monkeypatch: pytest.MonkeyPatch, error: type[OSError], channels: tuple[int, ...]
) -> None:
    motor = open_motor(LEFT)
    motor.set_velocity(5.0)
    tried = []

    def fail(_device: object, register: int, *values: int) -> None:
        tried.append(register)
        raise error

    monkeypatch.setattr("drivers.raspberrypi.i2c_device.I2CDevice.write", fail)
    with pytest.raises(DeviceError):
        motor.stop()
    assert tried == [6 + 4 * channel for channel in channels]


def test_opening_an_address_without_a_chip_leaves_nothing_open(bus: Bus, raises: Raises) -> None:
    bus.unplug()
    before = len(list(Path("/proc/self/fd").iterdir()))
    with raises(DeviceError, "chip-unanswered"):
        open_motor(LEFT)
    assert len(list(Path("/proc/self/fd").iterdir())) == before


def test_bus_that_is_off_is_an_error_with_its_overlay(bus: Bus, raises: Raises) -> None:
    with raises(DeviceError, "i2c-off"):
        open_motor({**LEFT, "bus": 3})


def test_chip_of_another_run_is_refused_and_its_motors_turn_on(bus: Bus, raises: Raises) -> None:
    robot = build_robot(left_motor=LEFT)
    context = build_context(robot)
    (motor,) = open_devices(robot, context)
    motor.set_velocity(5.0)
    with raises(DeviceError, "chip-held"):
        open_motor(LEFT)
    assert find_on(bus) == {8: 0.5, 9: 1.0}
    context.shared.close()
    open_motor(LEFT)


@pytest.mark.parametrize("error, kind", [(13, "no-permission-i2c"), (16, "chip-in-kernel")])
def test_closed_bus_and_driver_of_the_kernel_are_named(
    bus: Bus, error: int, kind: str, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    def refuse(*_arguments: object) -> None:
        raise OSError(error, os.strerror(error))

    monkeypatch.setattr("drivers.raspberrypi.i2c_device.ioctl", refuse)
    with raises(DeviceError, kind):
        open_motor(LEFT)


def test_one_wrong_frequency_is_one_mistake() -> None:
    left, right = {**LEFT, "frequency_hz": 50}, {**RIGHT, "frequency_hz": 400}
    with pytest.raises(DescriptionError) as caught:
        bind_devices(build_robot(left_motor=left, right_motor=right, pan=PAN), "raspberrypi")
    assert caught.value.others == ()


def test_another_chip_at_the_address_is_refused_before_a_write(bus: Bus, raises: Raises) -> None:
    bus.chip.write_bytes(bytes([0x39] * 256))
    with raises(DeviceError, "wrong-chip"):
        open_motor(LEFT)
    assert list(bus.transfers()) == []


def test_chip_that_does_not_keep_its_registers_is_refused(
    bus: Bus, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    monkeypatch.setattr("drivers.raspberrypi.i2c_device.I2CDevice.read", lambda _device, _register: 0x09)
    with raises(DeviceError, "wrong-chip"):
        open_motor(LEFT)


def test_chip_with_an_external_clock_is_off_and_refused(bus: Bus, raises: Raises) -> None:
    bus.switch_on()
    with bus.chip.open("r+b") as registers:
        registers.write(b"\x61")
    with raises(DeviceError, "external-clock"):
        open_motor(LEFT)
    assert find_on(bus) == {}


def test_failure_to_close_the_chip_names_a_device_of_the_robot(bus: Bus) -> None:
    robot = build_robot(left_motor=LEFT)
    context = build_context(robot)
    open_devices(robot, context)
    bus.unplug()
    with pytest.raises(DeviceError) as raised:
        context.shared.close()
    assert (raised.value.kind, raised.value.device) == ("chip-unanswered", "left_motor")


def test_chip_that_lost_power_is_reported_at_the_next_command(bus: Bus, raises: Raises) -> None:
    motor = open_motor(LEFT)
    bus.lose_power()
    with raises(DeviceError, "chip-reset"):
        motor.set_velocity(5.0)
    motor.stop()
    assert find_on(bus) == {}


def test_hung_bus_is_an_error_within_its_limit(bus: Bus, raises: Raises) -> None:
    motor = open_motor(LEFT)
    assert int(bus.folder.joinpath("timeout").read_text()) == 100 * TIMEOUT_S  # in units of 10 ms
    bus.hang(TIMEOUT_S)
    begin = time.monotonic()
    with raises(DeviceError, "chip-unanswered"):
        motor.set_velocity(5.0)
    assert time.monotonic() - begin < 1.0


MISTAKES: dict[str, dict[str, Mapping[str, Any]]] = {
    "pin-conflict": {"left_motor": LEFT, "right_motor": LEFT},
    "pin-conflict of one motor": {"left_motor": {**LEFT, "backward": 9}},
    "pin-conflict of a servo": {"left_motor": {**LEFT, "frequency_hz": 50}, "pan": {**PAN, "channel": 8}},
    "frequency-conflict": {"left_motor": LEFT, "right_motor": {**RIGHT, "frequency_hz": 400}},
    "frequency-conflict of a servo": {"left_motor": LEFT, "pan": PAN},
    "unknown-board": {"left_motor": {**LEFT, "board": "motor-hat"}},
    "unknown-motor": {"left_motor": {**LEFT, "motor": "M5"}},
    "unknown-motor without a name": {"left_motor": {**LEFT, "motor": 1}},
    "missing-key": {"left_motor": {"driver": "pca9685-motor", "forward": 0, "model": MODEL}},
    "out-of-bounds": {"left_motor": {**LEFT, "pwm": 16}},
    "setting-conflict": {"left_motor": {**LEFT, "model": {"forward_rad_s": 5.0, "backward_rad_s": 10.0}}},
}
"""Wrong tables, by the kind of their error."""


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_in_the_robots_file_is_reported(mistake: str, raises: Raises) -> None:
    with raises(DescriptionError, mistake.split(maxsplit=1)[0]):
        bind_devices(build_robot(**MISTAKES[mistake]), "raspberrypi")


def test_another_chip_at_the_address_is_a_mistake(raises: Raises) -> None:
    robot = build_robot(left_motor={**TWO_CHANNELS, "address": 0x68})
    tables = {**robot.backends["raspberrypi"], "imu": {"driver": "mpu6050"}}
    imu = ImuDescription(kind="imu", name="imu")
    both = robot.model_copy(update={"devices": (*robot.devices, imu), "backends": {"raspberrypi": tables}})
    with raises(DescriptionError, "pin-conflict"):
        bind_devices(both, "raspberrypi")


def test_servos_and_motors_with_their_frequency_share_a_chip() -> None:
    tables: dict[str, Mapping[str, Any]] = {
        "left_motor": {**LEFT, "frequency_hz": 50},
        "right_motor": {**RIGHT, "frequency_hz": 50},
        "pan": PAN,
    }
    assert len(bind_devices(build_robot(**tables), "raspberrypi")) == 3
    other_chip: dict[str, Mapping[str, Any]] = {"left_motor": LEFT, "pan": {**PAN, "address": 0x40, "channel": 8}}
    assert len(bind_devices(build_robot(**other_chip), "raspberrypi")) == 2


@pytest.mark.parametrize("table", [LEFT, TWO_CHANNELS], ids=["board", "chip"])
def test_notes_name_the_terminal_and_the_dangers(table: dict[str, Any], check_text: CheckText) -> None:
    (binding,) = bind_devices(build_robot(left_motor=table), "raspberrypi")
    check_text("\n".join(binding.notes))
    check_text("\n".join(f"{wire.signal}: {wire}" for wire in binding.driver.connections()))
