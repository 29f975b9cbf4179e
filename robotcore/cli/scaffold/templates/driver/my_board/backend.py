"""The backend: opens a robot's devices on the board."""

from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing
from functools import partial
from typing import Any

from robotcore.description import (
    AnyDevice,
    BatteryDescription,
    Drive,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    RobotDescription,
    StrictModel,
)
from robotcore.errors import DeviceError
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Device
from robotcore.hal.robot import Robot

from my_board.board import Board
from my_board.devices import BoardBattery, BoardEncoder, BoardMotor, BoardRange
from my_board.failures import in_words


class MyBoardOptions(StrictModel):
    """Options for ``--option``, each as a field: ``port: str = "/dev/ttyUSB0"``. Nothing yet."""


class MyBoardBackend(Backend):
    """Opens the robot that is on the board; ``connect`` finds the board."""

    name = "my-board"
    summary = "a board that is made up: two wheels, encoders, and a wall ahead"
    capabilities = frozenset(
        {Capability.LOCKSTEP}
    )  # for its time is simulated; that of a real board goes on by itself: none
    is_exclusive = True
    modules = ()  # the board's library

    def __init__(self, connect: Callable[[], Board] = Board) -> None:
        self._connect = connect

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        """Return all that are described: the board can tell of one. Every run opens them, whatever its app needs."""
        return frozenset(battery.name for battery in robot.all_of(BatteryDescription))

    def open(self, setup: Setup) -> Robot:
        """Open the devices asked for; where one cannot be, close the others again."""
        setup.options_as(MyBoardOptions)
        with ExitStack() as opened:
            with in_words(self.name):
                board = self._connect()
            opened.callback(board.disconnect)
            clock = board.clock(setup.rate_hz)
            opened.callback(clock.close)
            open_one = partial(_opened, setup.robot.drive, board, clock)
            devices = setup.open_each(lambda description: opened.enter_context(closing(open_one(description))))
            opened.pop_all()
        return Robot(setup.robot.name, clock, devices, release=board.disconnect)


def _opened(drive: Drive | None, board: Board, clock: Clock, description: AnyDevice) -> Device:
    match description:
        case MotorDescription():
            return BoardMotor(description, board, _wheel_of(description.name, drive))
        case EncoderDescription():
            return BoardEncoder(description, board, _wheel_of(description.name, drive), clock)
        case RangeSensorDescription():
            return BoardRange(description, board, clock)
        case BatteryDescription():
            return BoardBattery(description, board, clock)
    raise DeviceError(description.name, f"a {description.kind} is nothing that the board has")


def _wheel_of(device: str, drive: Drive | None) -> str:
    """Return which wheel a motor turns or an encoder counts."""
    if drive and device in (drive.left, drive.left_encoder):
        return "left"
    if drive and device in (drive.right, drive.right_encoder):
        return "right"
    raise DeviceError(device, "is on no wheel; name it in the robot's [drive]")
