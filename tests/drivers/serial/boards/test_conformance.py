"""The devices of each board pass the conformance kit. Variants of firmware and motors pass the rules for drives."""

from __future__ import annotations

from contextlib import suppress
from typing import Any, ClassVar

from robotcore.errors import DeviceError
from robotcore.geometry import Pose, Wheels
from robotcore.hal.backend import Setup
from robotcore.hal.drive import Odometry, WheelPath
from robotcore.hal.robot import Robot
from robotcore.kinds.motor import Motor
from robotcore.testing import ConformanceSuite, TestSupport
from robotcore.testing.bench import RATE_HZ
from robotcore.testing.fakes import CommandSpy
from tests.doubles.serial.bench import SerialBench, board_devices
from tests.doubles.serial.board import BoardDouble
from tests.doubles.serial.hoverboard import Hoverboard
from tests.doubles.serial.rosarduino import RobotcoreBridgeDouble, RosArduinoBridgeDouble
from tests.doubles.serial.sabertooth import Sabertooths
from tests.doubles.serial.waveshare import WaveshareBoard
from tests.robotcore.testing.variant_suites import DriveAndRangeSuite, DriveSuite

LONG = {"board_timeout_s": 5.0}
"""The kit lets a wheel turn for seconds after one command, so the board must not stop it earlier."""

MODEL = {"model": {"forward_rad_s": 16.0, "backward_rad_s": 16.0}}
CYCLES = 3840
"""The edges of the rover's encoders, whose ``counts_per_turn`` are cycles."""


class TestRobotcoreBridge(SerialBench, ConformanceSuite):
    devices: ClassVar = board_devices("ros-arduino", LONG, nose={}, battery={})

    def board(self) -> BoardDouble:
        return RobotcoreBridgeDouble(counts_per_turn=CYCLES)


class TestRosArduinoBridge(SerialBench, DriveAndRangeSuite):
    devices: ClassVar = board_devices("ros-arduino", LONG, nose={"pin": 7})

    def board(self) -> BoardDouble:
        return RosArduinoBridgeDouble(CYCLES, takes_duties=False)


class TestRobotcoreBridgeByDuty(SerialBench, DriveSuite):
    devices: ClassVar = board_devices("ros-arduino", LONG | MODEL)

    def board(self) -> BoardDouble:
        return RobotcoreBridgeDouble(counts_per_turn=CYCLES)


class TestWaveshare(SerialBench, ConformanceSuite):
    devices: ClassVar = board_devices("waveshare", LONG, battery={})

    def board(self) -> BoardDouble:
        return WaveshareBoard(2 * self.drive.wheel_radius_m)


class TickingBench(SerialBench):
    """Repeats the last command of each motor in each tick, because the board's time-out cannot be set."""

    lacks: ClassVar = {**SerialBench.lacks, TestSupport.CUTOFFS: "this bench repeats commands"}

    def open(self, setup: Setup) -> Robot:
        robot = super().open(setup)
        spies = {device: CommandSpy(device) for device in robot.devices.values() if isinstance(device, Motor)}

        def tick() -> None:
            for motor, spy in spies.items():
                if abs(spy.last) > 0:  # NaN before the first command
                    with suppress(DeviceError):  # the kit has cut the wire of the motor
                        motor.set_velocity(spy.last)

        robot.clock.call_every(1 / RATE_HZ, tick, "the app's ticks")
        return robot


class TestHoverboardBySpeed(TickingBench, ConformanceSuite):
    devices: ClassVar = board_devices("hoverboard", {"mode": "speed"}, battery={})

    def board(self) -> BoardDouble:
        return Hoverboard()


class TestHoverboardByDuty(TickingBench, DriveSuite):
    devices: ClassVar = board_devices("hoverboard", {"mode": "duty", "tank_steering": True, **MODEL})

    def board(self) -> BoardDouble:
        return Hoverboard(16.0 / 1000, is_tank=True)


class TestSabertooth(SerialBench, ConformanceSuite):
    """The kit reads the double's wheels, as the board sends nothing."""

    devices: ClassVar[dict[str, dict[str, Any]]] = {
        f"{side}_motor": {"driver": "sabertooth-motor", "motor": motor, **MODEL, **LONG}
        for motor, side in ((1, "left"), (2, "right"))
    }

    def board(self) -> BoardDouble:
        line = Sabertooths()
        self.odometry = Odometry(
            self.drive.geometry, lambda: WheelPath(Wheels(line.wheels.left.angle, line.wheels.right.angle))
        )
        return line

    def measure_pose(self, robot: Robot) -> Pose:
        return self.odometry.pose()
