from __future__ import annotations

import math
from typing import Any

import pytest

from robotcore.description import load_robot
from robotcore.errors import DescriptionError, DeviceError, DeviceGroupError, DeviceLostError
from robotcore.hal.devices import Battery, Encoder, Motor, RangeSensor
from robotcore.hal.robot import Robot
from tests.doubles.serial.rosarduino import ArduinoDouble, RobotcoreBridgeDouble, RosArduinoBridgeDouble
from tests.drivers.serial.boards.rosarduino.rig import ENCODERS, MODEL, MOTORS, WHEELS, Rig, pass_time
from tests.texts import CheckText, Raises

ROBOTCORE_BRIDGE_COUNT_RAD_S = math.tau / 960 * 30
"""The velocity of one count per control period of robotcore_bridge, in rad/s."""

ROS_ARDUINO_BRIDGE_COUNT_RAD_S = math.tau / 960 / 0.033
"""The velocity of one count per control period of ROSArduinoBridge, whose control period is 33 ms, in rad/s."""


def motor(robot: Robot, side: str) -> Motor:
    found = robot[f"{side}_motor"]
    assert isinstance(found, Motor)
    return found


def encoder(robot: Robot, side: str) -> Encoder:
    found = robot[f"{side}_encoder"]
    assert isinstance(found, Encoder)
    return found


def angle(robot: Robot, side: str) -> float:
    return encoder(robot, side).read().angle


@pytest.mark.parametrize(
    "board, unit",
    [
        (RobotcoreBridgeDouble(), ROBOTCORE_BRIDGE_COUNT_RAD_S),
        (RosArduinoBridgeDouble(), ROS_ARDUINO_BRIDGE_COUNT_RAD_S),
    ],
)
def test_set_velocity_returns_the_velocity_of_whole_counts(rig: Rig, board: ArduinoDouble, unit: float) -> None:
    with rig.open(board, WHEELS) as robot:
        assert motor(robot, "left").set_velocity(4.0) == pytest.approx(round(4.0 / unit) * unit)
        assert motor(robot, "right").set_velocity(-0.6 * unit) == pytest.approx(-unit)
        pass_time(robot, 0.02)
        assert board.commands[-1] != "m 0 0"
        assert [line for line in board.commands if line[0] == "m"][-1] == f"m {round(4.0 / unit)} -1"


def test_less_than_half_a_count_becomes_zero(rig: Rig) -> None:
    board = RobotcoreBridgeDouble()
    with rig.open(board, WHEELS) as robot:
        assert motor(robot, "left").set_velocity(0.4 * ROBOTCORE_BRIDGE_COUNT_RAD_S) == 0
        pass_time(robot, 0.02)
    assert {line for line in board.commands if line[0] == "m"} == {"m 0 0"}


def test_the_maximum_is_a_whole_number_of_counts_within_the_description(rig: Rig) -> None:
    with rig.open(RobotcoreBridgeDouble(), WHEELS) as robot:
        assert motor(robot, "left").max_velocity == pytest.approx(
            math.floor(12.0 / ROBOTCORE_BRIDGE_COUNT_RAD_S) * ROBOTCORE_BRIDGE_COUNT_RAD_S
        )


def test_robotcore_bridge_stops_after_the_time_out_of_the_settings(rig: Rig) -> None:
    board = RobotcoreBridgeDouble()
    with rig.open(board, WHEELS) as robot:
        motor(robot, "left").set_velocity(4.0)
        pass_time(robot, 0.4)
        assert board.deadman_s == 0.5
        assert board.wheels.left.command > 0
        pass_time(robot, 0.2)
        assert board.wheels.left.command == 0


def test_closing_leaves_no_wheel_turning(rig: Rig) -> None:
    board = RobotcoreBridgeDouble()
    with rig.open(board, WHEELS) as robot:
        motor(robot, "left").set_velocity(4.0)
        motor(robot, "right").set_velocity(4.0)
        pass_time(robot, 0.1)
        assert board.wheels.left.command > 0 < board.wheels.right.command
    assert board.commands[-1] == "m 0 0" or board.wheels.left.command == board.wheels.right.command == 0


def test_the_motors_of_a_tick_share_one_line(rig: Rig) -> None:
    board = RobotcoreBridgeDouble()
    with rig.open(board, WHEELS) as robot:
        motor(robot, "left").set_velocity(4.0)
        motor(robot, "right").set_velocity(-4.0)
        pass_time(robot, 0.05)
        assert [line for line in board.commands if line[0] == "m"][-2:] == ["m 0 0", "m 20 -20"]


def test_an_unplugged_board_stands_until_a_new_command_and_its_angles_continue(rig: Rig, raises: Raises) -> None:
    board = RobotcoreBridgeDouble()
    with rig.open(board, WHEELS) as robot:
        motor(robot, "left").set_velocity(4.0)
        pass_time(robot, 0.4)
        before = angle(robot, "left")
        rig.pty.unplug()
        pass_time(robot, 0.1)
        with raises(DeviceLostError, "port-lost", device="left_motor"):
            motor(robot, "left").set_velocity(4.0)
        rig.pty.plug_in()
        pass_time(robot, 1.0)
        assert board.wheels.left.command == 0
        assert angle(robot, "left") == pytest.approx(before, abs=0.25)  # it coasts
        motor(robot, "left").set_velocity(4.0)
        pass_time(robot, 0.2)
        assert angle(robot, "left") > before + 0.5


def test_the_shipped_rover_and_firmware_agree_on_the_speed(rig: Rig) -> None:
    """FULL_SPEED in the firmware's config.h is for the counts per turn of the double's wheel."""
    board, shipped = RobotcoreBridgeDouble(), load_robot("rover").backends["serial"]
    on_board = {name: {**table, "port": str(rig.pty.path)} for name, table in shipped.items() if name != "eye"}
    with rig.open(board, on_board) as robot:
        motor(robot, "left").set_velocity(4.0)
        pass_time(robot, 0.1)
        assert board.wheels.left.command == pytest.approx(4.0, rel=0.03)


def test_cycles_are_four_counts_each(rig: Rig) -> None:
    cycles = {name: {**section, "counts": "cycles"} for name, section in ENCODERS.items()}
    board = RobotcoreBridgeDouble(counts_per_turn=3840)
    with rig.open(board, {**MOTORS, **cycles}) as robot:
        motor(robot, "left").set_velocity(4.0)
        pass_time(robot, 0.5)
        assert angle(robot, "left") == pytest.approx(board.wheels.left.angle, abs=0.05)
        assert board.wheels.left.velocity == pytest.approx(4.0, rel=0.02)


def test_a_motor_by_duty_is_held_by_its_encoder(rig: Rig) -> None:
    weak = {"model": {"forward_rad_s": 20.0, "backward_rad_s": 20.0}, "control": {}}
    motors = {name: {**section, **weak} for name, section in MOTORS.items()}
    board = RobotcoreBridgeDouble()
    with rig.open(board, {**motors, **ENCODERS}) as robot:
        for _ in range(60):
            motor(robot, "left").set_velocity(4.0)
            pass_time(robot, 0.05)
        assert board.wheels.left.velocity == pytest.approx(4.0, rel=0.1)
        assert board.commands[-2][0] in "oe"


@pytest.mark.parametrize(
    "board, devices",
    [
        (RosArduinoBridgeDouble(), {"nose": {"driver": "ros-arduino-sonar"}}),
        (RosArduinoBridgeDouble(takes_duties=False), {"left_motor": {**MOTORS["left_motor"], **MODEL}}),
    ],
    ids=["sonar-without-pin", "duties"],
)
def test_features_that_ros_arduino_bridge_lacks_are_reported_with_a_remedy(
    rig: Rig, board: ArduinoDouble, devices: dict[str, dict[str, Any]], raises: Raises
) -> None:
    with raises(DeviceError, "firmware-lacks"):
        rig.open(board, devices)


def test_a_board_without_wheels_is_reported(rig: Rig, raises: Raises) -> None:
    board = RosArduinoBridgeDouble()
    board.has_wheels = False
    with raises(DeviceGroupError) as caught:
        rig.open(board, WHEELS)
    assert {failure.kind for failure in caught.value.failures if isinstance(failure, DeviceError)} == {
        "board-without-wheels"
    }


def test_an_unknown_version_is_reported(rig: Rig, raises: Raises) -> None:
    board = RobotcoreBridgeDouble()
    board.version = 2
    with raises(DeviceGroupError) as caught:
        rig.open(board, WHEELS)
    assert {failure.kind for failure in caught.value.failures if isinstance(failure, DeviceError)} == {
        "firmware-version"
    }


@pytest.mark.parametrize(
    "board",
    [RobotcoreBridgeDouble(millivolts=-1), RosArduinoBridgeDouble()],
    ids=["not-wired", "ros-arduino-bridge"],
)
def test_a_battery_that_the_board_does_not_measure_is_noted(
    rig: Rig, board: ArduinoDouble, check_text: CheckText
) -> None:
    with rig.open(board, {"battery": {"driver": "ros-arduino-battery"}}) as robot:
        assert "battery" not in robot.devices
        check_text(robot.notes[0])


def test_a_battery_is_reported_in_volts(rig: Rig) -> None:
    with rig.open(RobotcoreBridgeDouble(), {"battery": {"driver": "ros-arduino-battery"}}) as robot:
        battery = robot["battery"]
        assert isinstance(battery, Battery)
        assert battery.read().voltage == 7.4


@pytest.mark.parametrize("board, pin", [(RobotcoreBridgeDouble(), {}), (RosArduinoBridgeDouble(), {"pin": 7})])
def test_a_range_is_reported_in_metres(rig: Rig, board: ArduinoDouble, pin: dict[str, int]) -> None:
    with rig.open(board, {"nose": {"driver": "ros-arduino-sonar", **pin}}) as robot:
        nose = robot["nose"]
        assert isinstance(nose, RangeSensor)
        assert nose.read().distance == 0.5


@pytest.mark.parametrize(
    "devices",
    [
        MOTORS,
        {**WHEELS, "left_motor": {**MOTORS["left_motor"], "port": "COM3"}},
        {**WHEELS, "left_motor": {**MOTORS["left_motor"], "control": {}}},
        {**WHEELS, "right_motor": MOTORS["left_motor"]},
    ],
    ids=["no-encoders", "encoder-on-another-port", "control-without-model", "one-side-twice"],
)
def test_impossible_settings_are_refused_before_anything_opens(
    rig: Rig, devices: dict[str, dict[str, Any]], raises: Raises
) -> None:
    with raises(DescriptionError):
        rig.open(RobotcoreBridgeDouble(), devices)


def test_one_motor_with_a_model_and_one_without_are_refused(rig: Rig, raises: Raises) -> None:
    devices = {**WHEELS, "left_motor": {**MOTORS["left_motor"], **MODEL}}
    with raises(DeviceError, "motors-differ"):
        rig.open(RobotcoreBridgeDouble(), devices)
