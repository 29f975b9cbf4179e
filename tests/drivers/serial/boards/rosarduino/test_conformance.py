"""Devices on an Arduino pass the conformance kit; the other firmware and motors by duty pass the rules for drives."""

from __future__ import annotations

from typing import Any, ClassVar

from robotcore.description import BatteryDescription
from robotcore.testing import ConformanceSuite
from tests.doubles.serial.bench import SerialBench
from tests.doubles.serial.rosarduino import ArduinoDouble, RobotcoreBridgeDouble, RosArduinoBridgeDouble
from tests.robotcore.testing.variant_suites import DriveAndRangeSuite, DriveSuite

COUNTS = {"counts": "edges"}
LONG = {"board_timeout_s": 5.0}
"""The kit lets a wheel turn for seconds after one command, so the board must not stop it earlier."""

SIDES: dict[str, dict[str, Any]] = {
    "left_motor": {"driver": "ros-arduino-motor", "side": "left", **LONG},
    "right_motor": {"driver": "ros-arduino-motor", "side": "right", **LONG},
    "left_encoder": {"driver": "ros-arduino-encoder", "side": "left", **COUNTS},
    "right_encoder": {"driver": "ros-arduino-encoder", "side": "right", **COUNTS},
}
MODEL = {"model": {"forward_rad_s": 16.0, "backward_rad_s": 16.0}}


class TestRobotcoreBridge(SerialBench, ConformanceSuite):
    devices: ClassVar = {
        **SIDES,
        "nose": {"driver": "ros-arduino-sonar"},
        "battery": {"driver": "ros-arduino-battery"},
    }
    extra: ClassVar = (BatteryDescription(kind="battery", name="battery"),)

    def board(self) -> ArduinoDouble:
        return RobotcoreBridgeDouble()


class TestRosArduinoBridge(SerialBench, DriveAndRangeSuite):
    devices: ClassVar = {**SIDES, "nose": {"driver": "ros-arduino-sonar", "pin": 7}}

    def board(self) -> ArduinoDouble:
        return RosArduinoBridgeDouble(takes_duties=False)


class TestByDuty(SerialBench, DriveSuite):
    devices: ClassVar = {name: {**section, **(MODEL if "motor" in name else {})} for name, section in SIDES.items()}

    def board(self) -> ArduinoDouble:
        return RobotcoreBridgeDouble()
