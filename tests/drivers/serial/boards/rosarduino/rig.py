"""A rover on an Arduino's double, on a pty, in simulated time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from drivers.serial import backend as module
from drivers.serial.backend import SerialBackend
from robotcore.description import BatteryDescription, RobotDescription, load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.robot import Robot
from robotcore.testing import scenes
from tests.doubles.serial.bench import wired
from tests.doubles.serial.board import PERIOD_S, Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.rosarduino import ArduinoDouble

RATE_HZ = 20.0
BATTERY = BatteryDescription(kind="battery", name="battery")

MOTORS: dict[str, dict[str, Any]] = {
    "left_motor": {"driver": "ros-arduino-motor", "side": "left"},
    "right_motor": {"driver": "ros-arduino-motor", "side": "right"},
}
ENCODERS: dict[str, dict[str, Any]] = {
    "left_encoder": {"driver": "ros-arduino-encoder", "side": "left", "counts": "edges"},
    "right_encoder": {"driver": "ros-arduino-encoder", "side": "right", "counts": "edges"},
}
WHEELS = {**MOTORS, **ENCODERS}
MODEL = {"model": {"forward_rad_s": 16.0, "backward_rad_s": 16.0}}


class Rig:
    """Opens a robot on a board; ``board`` and ``pty`` are the other end."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self.pty = Pty(folder)
        self._patch = patch

    def open(self, board: ArduinoDouble, devices: Mapping[str, Mapping[str, Any]]) -> Robot:
        self._patch.setattr(module, "MonotonicClock", lambda: self._clock(board))
        robot = self.described(devices)
        names = frozenset(told.name for told in robot.devices)
        return SerialBackend().open(Setup(robot, scenes.empty(), names, RATE_HZ))

    def described(self, devices: Mapping[str, Mapping[str, Any]]) -> RobotDescription:
        return wired(load_robot("rover"), devices, self.pty.path, (BATTERY,))

    def _clock(self, board: ArduinoDouble) -> Clock:
        clock = SteppedClock(RATE_HZ, lambda _steps: None, PERIOD_S)
        Powered(board, self.pty, clock)
        return clock


def let_pass(robot: Robot, seconds: float) -> None:
    robot.clock.sleep_until(robot.clock.now() + seconds)
