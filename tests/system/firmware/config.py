"""The sketch's config.h for the simulated robot, and the rover's description for the serial drivers."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path
from typing import Any

from drivers.serial.backend import SECTION
from robotcore.description import RobotDescription, load_robot
from robotcore.kinds.battery import BatteryDescription
from tests.system.firmware.simulated import WheelPins, Wiring

ROVER = {
    "BATTERY_PIN": "A0",
    "START_DUTY": 26,  # a dead band of 0.1
    "FULL_SPEED": 71,  # 14 rad/s, 960 counts a turn
}
"""The values in config.h for the simulated robot."""

FULL_V = 5.0
"""The greatest voltage that an analog channel measures, in volts: the board's supply."""


def wiring(sketch: Path) -> Wiring:
    """Return the wiring of a robot with the pins in a sketch's config.h."""
    defines = dict(re.findall(r"(?m)^#define (\w+) (\w+)", (sketch / "config.h").read_text()))

    def pin(name: str) -> int:
        return _number(defines[f"{name}_PIN"])

    def wheel_pins(name: str) -> WheelPins:
        words = ("FORWARD", "BACKWARD", "ENCODER_A", "ENCODER_B", "ENABLE")
        return WheelPins(*(pin(f"{name}_{word}") for word in words))

    return Wiring(
        wheel_pins("LEFT"),
        wheel_pins("RIGHT"),
        trigger=pin("SONAR_TRIGGER"),
        echo=pin("SONAR_ECHO"),
        battery=pin("BATTERY") - _number("A0"),
        battery_ratio=1000 * FULL_V / int(defines["BATTERY_FULL_SCALE_MV"]),
    )


def _number(pin: str) -> int:
    return 14 + int(pin[1:]) if pin.startswith("A") else int(pin)


BOARD_TIMEOUT_S = 0.5
ANSWER_S, MAX_AGE_S = 60, 3.0

CONNECTED: dict[str, dict[str, Any]] = {
    "left_motor": {"driver": "ros-arduino-motor", "side": "left", "board_timeout_s": BOARD_TIMEOUT_S},
    "right_motor": {"driver": "ros-arduino-motor", "side": "right", "board_timeout_s": BOARD_TIMEOUT_S},
    "left_encoder": {"driver": "ros-arduino-encoder", "side": "left", "counts": "edges"},
    "right_encoder": {"driver": "ros-arduino-encoder", "side": "right", "counts": "edges"},
    "nose": {"driver": "ros-arduino-sonar"},
    "battery": {"driver": "ros-arduino-battery"},
}


def load_rover_with_battery() -> RobotDescription:
    """Return the rover with the battery that the board measures."""
    rover = load_robot("rover")
    battery = BatteryDescription(kind="battery", name="battery")
    return rover.model_copy(update={"devices": (*rover.devices, battery)})


def on_serial(robot: RobotDescription, port: Path, board_timeout_s: float) -> RobotDescription:
    """Return the robot with a section [serial] for the serial drivers."""
    names = {device.name for device in robot.devices}
    section = {name: {**table, "port": str(port)} for name, table in CONNECTED.items() if name in names}
    for motor in (table for table in section.values() if "board_timeout_s" in table):
        motor["board_timeout_s"] = board_timeout_s
    return robot.model_copy(update={"backends": {**robot.backends, SECTION: section}})


def write_rover_file(path: Path) -> Path:
    """Write the rover's file for a simulated robot, with time limits for a busy machine, and return its path."""
    rover = (files("robotcore.description") / "robots" / "rover.toml").read_text()
    patience = f"answer_s = {ANSWER_S}\nmax_age_s = {MAX_AGE_S}\n"
    path.write_text(rover.replace("max_age_s = 1.0\n", patience))
    return path
