"""Robots whose motors, encoders and nose are on one board that runs our firmware."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from drivers.serial.backend import SECTION
from robotcore.description import RobotDescription

CONNECTED: dict[str, dict[str, str]] = {
    "left_motor": {"driver": "ros-arduino-motor", "side": "left"},
    "right_motor": {"driver": "ros-arduino-motor", "side": "right"},
    "left_encoder": {"driver": "ros-arduino-encoder", "side": "left", "counts": "edges"},
    "right_encoder": {"driver": "ros-arduino-encoder", "side": "right", "counts": "edges"},
    "nose": {"driver": "ros-arduino-sonar"},
}


def on_serial(robot: RobotDescription, port: Path) -> RobotDescription:
    """Return a robot with its section for the serial drivers."""
    names = {told.name for told in robot.devices}
    section = {name: {**table, "port": str(port)} for name, table in CONNECTED.items() if name in names}
    return robot.model_copy(update={"backends": {**robot.backends, SECTION: section}})


def written(path: Path, port: Path) -> Path:
    """Write the rover's file with that section, as a user has it, and return where it is."""
    rover = files("robotcore.description") / "robots" / "rover.toml"
    tables = (f"[{SECTION}.{name}]\n{_lines({**table, 'port': str(port)})}" for name, table in CONNECTED.items())
    path.write_text("\n".join([rover.read_text(), *tables]))
    return path


def _lines(table: dict[str, str]) -> str:
    return "".join(f'{key} = "{value}"\n' for key, value in table.items())
