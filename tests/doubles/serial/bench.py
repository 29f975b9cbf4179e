"""A rover with devices on the double of a board, in simulated time: for single tests, and for the conformance kit."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

import pytest

from drivers.serial.backend import SECTION, SerialBackend
from robotcore.description import RobotDescription, load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.robot import Robot
from robotcore.hardware import backend as module
from robotcore.hardware import bind_devices, open_robot
from robotcore.kinds.battery import BatteryDescription
from robotcore.kinds.encoder import Encoder
from robotcore.kinds.motor import Motor
from robotcore.testing import TestSupport, worlds
from robotcore.testing.bench import RATE_HZ, TestBench
from tests.doubles.serial.board import PERIOD_S, BoardDouble, Powered
from tests.doubles.serial.pty import Pty

Devices: TypeAlias = Mapping[str, Mapping[str, Any]]
"""The table of each device on a board, without the port."""

BATTERY = BatteryDescription(kind="battery", name="battery")


def board_devices(board: str, motor: Mapping[str, Any] | None = None, **others: Mapping[str, Any]) -> Devices:
    """Return the tables of two motors, their encoders and ``others`` on one board.

    board: the first word of the drivers' names, such as ``waveshare``.
    motor: the settings of both motors besides the side.
    """
    return {
        **{f"{side}_motor": {"driver": f"{board}-motor", "side": side, **(motor or {})} for side in ("left", "right")},
        **{f"{side}_encoder": {"driver": f"{board}-encoder", "side": side} for side in ("left", "right")},
        **{
            name: {"driver": f"{board}-{'sonar' if name == 'nose' else name}", **table}
            for name, table in others.items()
        },
    }


def connect_devices(devices: Devices, port: object = "/dev/ttyUSB0") -> RobotDescription:
    """Return the rover with only these devices, all on one port. It keeps its drive if both motors are among them."""
    robot = load_robot("rover")
    connected = tuple(description for description in (*robot.devices, BATTERY) if description.name in devices)
    section = {name: {"port": str(port), **description} for name, description in devices.items()}
    drive = robot.drive if {"left_motor", "right_motor"} <= devices.keys() else None
    if drive and "left_encoder" not in devices:
        drive = drive.model_copy(update={"left_encoder": None, "right_encoder": None})
    return robot.model_copy(update={"devices": connected, "drive": drive, "backends": {SECTION: section}})


class SerialBench(TestBench):
    """The base class of the benches. A subclass sets ``devices`` and returns the double by `board`."""

    backend = SerialBackend
    devices: ClassVar[Devices]
    lacks: ClassVar[Mapping[TestSupport, str]] = {
        TestSupport.WORLD: "the board turns wheels without a world",
        TestSupport.LOST_ECHO: "no device on the board measures echoes",
        TestSupport.SLOW_HARDWARE: "in simulated time no thread waits",
    }

    @abstractmethod
    def board(self) -> BoardDouble:
        """Return a new board in its state after power-on."""

    @property
    def description(self) -> RobotDescription:
        return connect_devices(self.devices, self.pty.path)

    @pytest.fixture(autouse=True)
    def _connect_board(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
        with Pty(tmp_path) as self.pty:
            monkeypatch.setattr(module, "MonotonicClock", self._build_clock)
            yield

    def _build_clock(self) -> Clock:
        clock = SteppedClock(RATE_HZ, lambda _steps: None, PERIOD_S)
        self.powered = Powered(self.board(), self.pty, clock)
        return clock


class Rig:
    """The double of a board, its port, and a robot with devices on it."""

    def __init__(self, folder: Path, board: BoardDouble, devices: Devices) -> None:
        self.pty = Pty(folder)
        self.clock = SteppedClock(RATE_HZ, lambda _steps: None, PERIOD_S)
        self.powered = Powered(board, self.pty, self.clock)
        self.description = connect_devices(devices, self.pty.path)
        self._setup = Setup(self.description, worlds.empty(), frozenset(devices), RATE_HZ)
        self._robot: Robot | None = None

    @property
    def robot(self) -> Robot:
        """The robot; the first access opens it."""
        if self._robot is None:
            self._robot = open_robot(self._setup, bind_devices(self._setup.robot, SECTION), self.clock)
        return self._robot

    def motor(self, side: str) -> Motor:
        motor = self.robot[f"{side}_motor"]
        assert isinstance(motor, Motor)
        return motor

    def angle(self, side: str) -> float:
        encoder = self.robot[f"{side}_encoder"]
        assert isinstance(encoder, Encoder)
        return encoder.read().angle

    def read(self, device: str) -> Any:
        """Return the newest sample of a sensor."""
        sensor: Any = self.robot[device]
        return sensor.read()

    def drive(self, left: float, right: float, seconds: float = 0.0) -> None:
        """Command both wheels in rad/s in each tick for ``seconds``, once at least."""
        for _ in range(max(1, round(seconds * RATE_HZ))):
            self.motor("left").set_velocity(left)
            self.motor("right").set_velocity(right)
            self.pass_time(1 / RATE_HZ)

    def pass_time(self, seconds: float) -> None:
        """Let time pass."""
        self.clock.sleep_until(self.clock.now() + seconds)

    def close(self) -> None:
        """Close the robot and the board; raises the errors of closing the robot."""
        try:
            if self._robot:
                self._robot.close()
        finally:
            self.powered.off()
            self.pty.close()
