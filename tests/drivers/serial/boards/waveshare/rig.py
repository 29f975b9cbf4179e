"""A rover on a Waveshare UGV board, on a pty, in simulated time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from drivers.serial.backend import SECTION
from robotcore.description import BatteryDescription, RobotDescription, load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Battery, Encoder, Motor
from robotcore.hal.robot import Robot
from robotcore.hardware import open_robot
from robotcore.testing import worlds
from tests.doubles.serial.bench import connect_devices
from tests.doubles.serial.board import PERIOD_S, Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.waveshare import WaveshareBoard

RADIUS_M = 0.04


def devices(**motors: Any) -> dict[str, Mapping[str, Any]]:
    """Return the tables of all devices on one board. ``motors`` are further settings of the motors."""
    return {
        **{f"{side}_motor": {"driver": "waveshare-motor", "side": side, **motors} for side in ("left", "right")},
        **{f"{side}_encoder": {"driver": "waveshare-encoder", "side": side} for side in ("left", "right")},
        "battery": {"driver": "waveshare-battery"},
    }


def rover(port: Path, **motors: Any) -> RobotDescription:
    """Return the rover with the wheels of the UGV Rover, on a board at that port."""
    robot = load_robot("rover")
    assert robot.drive
    robot = robot.model_copy(update={"drive": robot.drive.model_copy(update={"wheel_radius_m": RADIUS_M})})
    return connect_devices(robot, devices(**motors), port, (BatteryDescription(kind="battery", name="battery"),))


class Rig:
    """A board, its port, and a robot that `open` opens on it."""

    def __init__(self, folder: Path) -> None:
        self.pty, self.board = Pty(folder), WaveshareBoard()
        self.clock = SteppedClock(20.0, lambda _steps: None, PERIOD_S)
        self._powered = Powered(self.board, self.pty, self.clock)
        self.robot: Robot | None = None

    def open(self, **motors: Any) -> Rig:
        description = rover(self.pty.path, **motors)
        names = frozenset(device.name for device in description.devices)
        self.robot = open_robot(Setup(description, worlds.empty(), names, 20.0), SECTION, self.clock)
        return self

    def drive(self, left: float, right: float, seconds: float = 0.0) -> None:
        """Command both wheels in rad/s at 20 Hz for ``seconds``, once at least."""
        for _ in range(max(1, round(20 * seconds))):
            self.motor("left").set_velocity(left)
            self.motor("right").set_velocity(right)
            self.pass_time(0.05)

    def pass_time(self, seconds: float) -> None:
        self.clock.sleep_until(self.clock.now() + seconds)

    def motor(self, side: str) -> Motor:
        motor = self._robot[f"{side}_motor"]
        assert isinstance(motor, Motor)
        return motor

    def angles(self) -> tuple[float, float]:
        """Return both encoders' angles, in rad."""
        left, right = self._robot["left_encoder"], self._robot["right_encoder"]
        assert isinstance(left, Encoder)
        assert isinstance(right, Encoder)
        return left.read().angle, right.read().angle

    def read_voltage(self) -> float:
        battery = self._robot["battery"]
        assert isinstance(battery, Battery)
        return battery.read().voltage

    def close(self) -> None:
        if self.robot:
            self.robot.close()
        self._powered.off()
        self.pty.close()

    @property
    def _robot(self) -> Robot:
        assert self.robot
        return self.robot
