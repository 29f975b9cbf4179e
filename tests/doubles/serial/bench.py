"""Test benches for the conformance kit: a rover with devices on the double of a board, in simulated time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

import pytest

from drivers.serial import backend as module
from drivers.serial.backend import SECTION, SerialBackend
from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DeviceError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.devices import Encoder, Motor
from robotcore.hal.robot import Robot
from robotcore.hardware import open_robot
from robotcore.testing import TestSupport, worlds
from robotcore.testing.bench import RATE_HZ, TestBench
from robotcore.testing.fakes import MotorSpy
from tests.doubles.serial.board import PERIOD_S, BoardDouble, Powered
from tests.doubles.serial.pty import Pty


class SerialBench(TestBench):
    """The base class of the benches. A subclass sets ``devices`` and returns the double by `board`.

    >>> class TestMyBoard(SerialBench, ConformanceSuite):
    ...     devices = {"left_motor": {"driver": "my-motor", "side": "left"}}
    ...     def board(self): return MyBoard(Wheels())
    """

    backend = SerialBackend
    devices: ClassVar[Mapping[str, Mapping[str, Any]]]
    """The table of each device on the board, without the port."""
    extra: ClassVar[tuple[Any, ...]] = ()
    """Descriptions of devices that the rover does not have, such as a battery."""

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
        return connect_devices(load_robot("rover"), self.devices, self.pty.path, self.extra)

    @pytest.fixture(autouse=True)
    def _connect_board(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
        with Pty(tmp_path) as self.pty:
            monkeypatch.setattr(module, "MonotonicClock", self._build_clock)
            yield

    def _build_clock(self) -> Clock:
        clock = SteppedClock(RATE_HZ, lambda _steps: None, PERIOD_S)
        self.powered = Powered(self.board(), self.pty, clock)
        return clock


def connect_devices(
    robot: RobotDescription, devices: Mapping[str, Mapping[str, Any]], port: Path, extra: tuple[Any, ...] = ()
) -> RobotDescription:
    """Return the robot with only these devices, all on one port. It keeps its drive if both motors are among them."""
    connected = tuple(description for description in (*robot.devices, *extra) if description.name in devices)
    section = {name: {"port": str(port), **description} for name, description in devices.items()}
    drive = robot.drive if {"left_motor", "right_motor"} <= devices.keys() else None
    if drive and "left_encoder" not in devices:
        drive = drive.model_copy(update={"left_encoder": None, "right_encoder": None})
    return robot.model_copy(update={"devices": connected, "drive": drive, "backends": {SECTION: section}})


class TickingBench(SerialBench):
    """Repeats the last command of each motor in each tick.

    The kit sends a command once and lets seconds pass, which is longer than the time-out of some boards.
    """

    def open(self, setup: Setup) -> Robot:
        robot = super().open(setup)
        spies = {device: MotorSpy(device) for device in robot.devices.values() if isinstance(device, Motor)}

        def tick() -> None:
            for motor, spy in spies.items():
                if abs(spy.last) > 0:  # NaN before the first command
                    with suppress(DeviceError):  # the kit has cut the wire of the motor
                        motor.set_velocity(spy.last)

        robot.clock.every(1 / RATE_HZ, tick, "the app's ticks")
        return robot


Devices = Mapping[str, Mapping[str, Any]]


class Rig:
    """The double of a board, its port, and a robot with devices on it."""

    def __init__(self, folder: Path, board: BoardDouble, devices: Devices, extra: tuple[Any, ...] = ()) -> None:
        self.pty = Pty(folder)
        self.clock = SteppedClock(RATE_HZ, lambda _steps: None, PERIOD_S)
        self._powered = Powered(board, self.pty, self.clock)
        described = connect_devices(load_robot("rover"), devices, self.pty.path, extra)
        self._setup = Setup(described, worlds.empty(), frozenset(devices), RATE_HZ)
        self._robot: Robot | None = None

    @property
    def robot(self) -> Robot:
        """The robot; the first access opens it."""
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
        """Command both wheels in rad/s in each tick for ``seconds``."""
        for _ in range(round(seconds * RATE_HZ)):
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
            self._powered.off()
            self.pty.close()
