"""Robots whose motors, encoders and nose are on one board that runs our firmware."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

from drivers.serial.backend import SECTION
from robotcore.description import BatteryDescription, RobotDescription, load_robot

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


def with_battery() -> RobotDescription:
    """Return the rover, with the battery that the board tells of."""
    rover = load_robot("rover")
    battery = BatteryDescription(kind="battery", name="battery")
    return rover.model_copy(update={"devices": (*rover.devices, battery)})


def on_serial(robot: RobotDescription, port: Path, board_timeout_s: float) -> RobotDescription:
    """Return a robot with its section for the serial drivers."""
    names = {told.name for told in robot.devices}
    section = {name: {**table, "port": str(port)} for name, table in CONNECTED.items() if name in names}
    for motor in (table for table in section.values() if "board_timeout_s" in table):
        motor["board_timeout_s"] = board_timeout_s
    return robot.model_copy(update={"backends": {**robot.backends, SECTION: section}})


def patient(path: Path) -> Path:
    """Write the rover's file for a simulated robot that a busy machine keeps waiting, and return where it is."""
    rover = (files("robotcore.description") / "robots" / "rover.toml").read_text()
    patience = f"answer_s = {ANSWER_S}\nmax_age_s = {MAX_AGE_S}\n"
    path.write_text(rover.replace("max_age_s = 1.0\n", patience))
    return path
