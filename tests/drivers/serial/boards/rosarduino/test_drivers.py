from __future__ import annotations

import math
from typing import Any

import pytest

from robotcore.description import load_robot
from robotcore.errors import DeviceError, DeviceGroupError
from tests.doubles.serial.bench import Devices, board_devices
from tests.doubles.serial.rosarduino import ArduinoDouble, RobotcoreBridgeDouble, RosArduinoBridgeDouble
from tests.drivers.serial.boards.conftest import OpenRig
from tests.texts import CheckText, Raises

MODEL = {"model": {"forward_rad_s": 16.0, "backward_rad_s": 16.0}}


def wheels(**motor: Any) -> Devices:
    """Return the tables of two motors and their encoders, with counts of edges."""
    devices = board_devices("ros-arduino", motor)
    return {name: {**table, **({"counts": "edges"} if "encoder" in name else {})} for name, table in devices.items()}


@pytest.mark.parametrize(
    "board, unit",
    [(RobotcoreBridgeDouble(), math.tau / 960 * 30), (RosArduinoBridgeDouble(), math.tau / 960 / 0.033)],
    ids=["robotcore_bridge", "ROSArduinoBridge"],
)
def test_velocities_are_whole_counts_in_a_control_period(open_rig: OpenRig, board: ArduinoDouble, unit: float) -> None:
    rig = open_rig(board, wheels())
    left = rig.motor("left")
    assert left.max_velocity == pytest.approx(math.floor(12.0 / unit) * unit)
    assert left.set_velocity(0.4 * unit) == 0
    rig.pass_time(0.02)
    assert {line for line in board.commands if line[0] == "m"} == {"m 0 0"}
    assert left.set_velocity(4.0) == pytest.approx(round(4.0 / unit) * unit)
    assert rig.motor("right").set_velocity(-0.6 * unit) == pytest.approx(-unit)
    rig.pass_time(0.02)
    assert [line for line in board.commands if line[0] == "m"][-2:] == ["m 0 0", f"m {round(4.0 / unit)} -1"]


def test_the_shipped_rover_and_firmware_agree_on_the_speed(open_rig: OpenRig) -> None:
    """FULL_SPEED in the firmware's config.h is for the counts per turn of the double's wheel."""
    shipped = load_robot("rover").backends["serial"]
    tables = {name: {key: value for key, value in table.items() if key != "port"} for name, table in shipped.items()}
    board = RobotcoreBridgeDouble()
    rig = open_rig(board, {name: table for name, table in tables.items() if name != "eye"})
    rig.motor("left").set_velocity(4.0)
    rig.pass_time(0.1)
    assert board.wheels.left.command == pytest.approx(4.0, rel=0.03)


def test_a_motor_by_duty_is_held_by_its_encoder(open_rig: OpenRig) -> None:
    board = RobotcoreBridgeDouble()
    rig = open_rig(board, wheels(model={"forward_rad_s": 20.0, "backward_rad_s": 20.0}, control={}))
    rig.drive(4.0, 4.0, 3.0)
    assert board.wheels.left.velocity == pytest.approx(4.0, rel=0.1)
    assert board.commands[-2][0] in "oe"


@pytest.mark.parametrize(
    "board, devices",
    [
        (RosArduinoBridgeDouble(), {"nose": {"driver": "ros-arduino-sonar"}}),
        (
            RosArduinoBridgeDouble(takes_duties=False),
            {"left_motor": {"driver": "ros-arduino-motor", "side": "left", **MODEL}},
        ),
    ],
    ids=["sonar-without-pin", "duties"],
)
def test_features_that_ros_arduino_bridge_lacks_are_reported_with_a_remedy(
    open_rig: OpenRig, board: ArduinoDouble, devices: Devices, raises: Raises
) -> None:
    with raises(DeviceError, "firmware-lacks"):
        _ = open_rig(board, devices).robot


@pytest.mark.parametrize(
    "attribute, board, kind",
    [
        ({"has_wheels": False}, RosArduinoBridgeDouble(), "board-without-wheels"),
        ({"version": 2}, RobotcoreBridgeDouble(), "firmware-version"),
    ],
    ids=["no-wheels", "version"],
)
def test_an_unsupported_firmware_is_reported(
    open_rig: OpenRig, board: ArduinoDouble, attribute: dict[str, Any], kind: str, raises: Raises
) -> None:
    vars(board).update(attribute)
    with raises(DeviceGroupError) as caught:
        _ = open_rig(board, wheels()).robot
    assert {failure.kind for failure in caught.value.failures if isinstance(failure, DeviceError)} == {kind}


@pytest.mark.parametrize(
    "board",
    [RobotcoreBridgeDouble(millivolts=-1), RosArduinoBridgeDouble()],
    ids=["not-wired", "ros-arduino-bridge"],
)
def test_a_battery_that_the_board_does_not_measure_is_noted(
    open_rig: OpenRig, board: ArduinoDouble, check_text: CheckText
) -> None:
    robot = open_rig(board, {"battery": {"driver": "ros-arduino-battery"}}).robot
    assert "battery" not in robot.devices
    check_text(robot.notes[0])


def test_one_motor_with_a_model_and_one_without_are_refused(open_rig: OpenRig, raises: Raises) -> None:
    devices = wheels()
    with raises(DeviceError, "motors-differ"):
        _ = open_rig(RobotcoreBridgeDouble(), {**devices, "left_motor": {**devices["left_motor"], **MODEL}}).robot
