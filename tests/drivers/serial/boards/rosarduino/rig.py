"""A rover on an Arduino's double, on a pty, in simulated time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from drivers.serial import backend as module
from drivers.serial.backend import SerialBackend
from drivers.serial.boards.rosarduino.board import ArduinoProtocol
from drivers.serial.boards.rosarduino.protocol import frame_line
from robotcore.description import BatteryDescription, RobotDescription, load_robot
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock, SteppedClock
from robotcore.hal.robot import Robot
from robotcore.testing import worlds
from tests.doubles.serial.bench import connect_devices
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
    """Opens a robot on a double of a board, which is connected by ``pty``."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self.pty = Pty(folder)
        self._patch = patch

    def open(self, board: ArduinoDouble, devices: Mapping[str, Mapping[str, Any]]) -> Robot:
        self._patch.setattr(module, "MonotonicClock", lambda: self._clock(board))
        robot = self.describe(devices)
        names = frozenset(device.name for device in robot.devices)
        return SerialBackend().open(Setup(robot, worlds.empty(), names, RATE_HZ))

    def describe(self, devices: Mapping[str, Mapping[str, Any]]) -> RobotDescription:
        return connect_devices(load_robot("rover"), devices, self.pty.path, (BATTERY,))

    def _clock(self, board: ArduinoDouble) -> Clock:
        clock = SteppedClock(RATE_HZ, lambda _steps: None, PERIOD_S)
        Powered(board, self.pty, clock)
        return clock


def pass_time(robot: Robot, seconds: float) -> None:
    robot.clock.sleep_until(robot.clock.now() + seconds)


BAUD = 57600
STEP_S = 0.002

PROBE = b"\rm 0 0\rv*76\rb\r"
ROBOTCORE_BRIDGE_REPLY = b"OK\r\nrobotcore-bridge 1*5C\r\n57600\r\n"
ROS_ARDUINO_BRIDGE_REPLY = b"Invalid Command\r\nOK\r\nInvalid Command\r\n57600\r\n"


def encode_request(text: str) -> bytes:
    return frame_line(text, is_summed=True)


def encode_reply(text: str) -> bytes:
    return frame_line(text, is_summed=True) + b"\n"


class ScriptedBoard:
    """A protocol, with the test as the board. ``now`` advances by `STEP_S` with each exchange."""

    def __init__(self) -> None:
        self.protocol = ArduinoProtocol(BAUD)
        self.now = 10.0
        self.protocol.begin(self.now)

    def next_data(self, after: float = STEP_S) -> bytes:
        """Return the data that the protocol sends ``after`` seconds from now."""
        self.now += after
        return self.protocol.data_to_send(self.now)

    def reply(self, data: bytes) -> None:
        self.now += STEP_S
        self.protocol.receive(data, self.now)

    def exchange(self, *turns: tuple[bytes, bytes]) -> None:
        """Expect requests one after another, and reply to each.

        turns: the expected request and the reply, several times.
        """
        for sent, received in turns:
            assert self.next_data() == sent
            self.reply(received)

    def identify_robotcore_bridge(self) -> None:
        """Exchange frames until robotcore_bridge is identified, and the protocol only polls counts."""
        self.exchange(
            (PROBE, ROBOTCORE_BRIDGE_REPLY),
            (encode_request("m 0 0"), encode_reply("OK")),
            (encode_request("k 2000"), encode_reply("OK")),
            (encode_request("e"), encode_reply("0 0")),
        )

    def identify_ros_arduino_bridge(self) -> None:
        self.exchange(
            (PROBE, ROS_ARDUINO_BRIDGE_REPLY),
            (PROBE, ROS_ARDUINO_BRIDGE_REPLY),
            (b"m 0 0\r", b"OK\r\n"),
            (b"o 0 0\r", b"Invalid Command\r\n"),
            (b"o 0 0\r", b"Invalid Command\r\n"),
            (b"m 0 0\r", b"OK\r\n"),
            (b"e\r", b"0 0\r\n"),
        )

    def set(self, left: float, right: float) -> None:
        """Set the commands of both motors in one tick."""
        self.protocol.command.set("left", left, self.now)
        self.protocol.command.set("right", right, self.now)

    @property
    def angle(self) -> float:
        """The angle of the left wheel in counts."""
        sample = self.protocol.counters["left"].angle(1.0)
        assert sample
        return sample.angle
