"""A rover whose devices are on one board's double, on a pty, in simulated time: opened, driven, unplugged."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from drivers.serial.backend import SECTION
from robotcore.description import load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Encoder, Motor
from robotcore.hal.robot import Robot
from robotcore.hardware import open_robot
from robotcore.testing import scenes
from robotcore.testing.bench import RATE_HZ
from tests.doubles.serial.bench import wired
from tests.doubles.serial.board import PERIOD_S, BoardDouble, Powered
from tests.doubles.serial.pty import Pty

Devices = Mapping[str, Mapping[str, Any]]


class Rig:
    """The board, its port, and the robot with these devices; closed with its pty."""

    def __init__(self, folder: Path, board: BoardDouble, devices: Devices, extra: tuple[Any, ...] = ()) -> None:
        self.pty = Pty(folder)
        self.clock = SteppedClock(RATE_HZ, lambda _steps: None, PERIOD_S)
        self._powered = Powered(board, self.pty, self.clock)
        described = wired(load_robot("rover"), devices, self.pty.path, extra)
        self._setup = Setup(described, scenes.empty(), frozenset(devices), RATE_HZ)
        self._robot: Robot | None = None

    @property
    def robot(self) -> Robot:
        """The robot, open from when it is first asked for."""
        if self._robot is None:
            self._robot = open_robot(self._setup, SECTION, self.clock)
        return self._robot

    def motor(self, side: str) -> Motor:
        motor = self.robot[f"{side}_motor"]
        assert isinstance(motor, Motor)
        return motor

    def angle(self, side: str) -> float:
        encoder = self.robot[f"{side}_encoder"]
        assert isinstance(encoder, Encoder)
        return encoder.read().angle

    def drive(self, left: float, right: float, seconds: float) -> None:
        """Command both wheels, rad/s, in each tick for so long."""
        for _ in range(round(seconds * RATE_HZ)):
            self.motor("left").set_velocity(left)
            self.motor("right").set_velocity(right)
            self.pass_by(1 / RATE_HZ)

    def pass_by(self, seconds: float) -> None:
        """Let time pass."""
        self.clock.sleep_until(self.clock.now() + seconds)

    def close(self) -> None:
        """Close what is open; raises what closing the robot does."""
        try:
            if self._robot:
                self._robot.close()
        finally:
            self._powered.off()
            self.pty.close()
