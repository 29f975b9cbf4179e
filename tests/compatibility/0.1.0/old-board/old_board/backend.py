"""The backend of old-board, which opens the devices of a robot."""

from collections.abc import Callable, Mapping
from contextlib import ExitStack, closing
from functools import partial
from typing import Any

from robotcore.description import DeviceDescription, Drive, RobotDescription, StrictModel
from robotcore.errors import DeviceError
from robotcore.hal.backend import Backend, Capability, Setup
from robotcore.hal.clock import Clock
from robotcore.hal.device import Device
from robotcore.hal.robot import Robot
from robotcore.kinds.battery import BatteryDescription
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.motor import MotorDescription
from robotcore.kinds.range_sensor import RangeSensorDescription

from old_board.board import Board
from old_board.devices import BoardBattery, BoardEncoder, BoardMotor, BoardRange
from old_board.error_translation import translate_errors


class OldBoardOptions(StrictModel):
    """The options that ``--option`` can set. Add a field for each, such as ``port: str = "/dev/ttyUSB0"``."""


class OldBoardBackend(Backend):
    """The backend of old-board.

    connect: a function that opens the connection to the board.
    """

    name = "old-board"
    summary = "an invented board: two wheels, encoders, and a wall ahead"
    capabilities = frozenset({Capability.LOCKSTEP})  # its time is simulated; a real board has no capability
    is_exclusive = True
    modules = ()  # the board's library

    def __init__(self, connect: Callable[[], Board] = Board) -> None:
        self._connect = connect

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        """Return the names of all devices, because the board has a battery too, which simulators lack."""
        return frozenset(device.name for device in robot.devices)

    def open(self, setup: Setup) -> Robot:
        """Open the chosen devices. If one cannot be opened, close the others."""
        setup.options_as(OldBoardOptions)
        with ExitStack() as opened:
            with translate_errors(self.name):
                board = self._connect()
            opened.callback(board.disconnect)
            clock = board.clock(setup.rate_hz)
            opened.callback(clock.close)
            open_one = partial(_open_device, setup.robot.drive, board, clock)
            devices = setup.open_each(lambda description: opened.enter_context(closing(open_one(description))))
            opened.pop_all()
        return Robot(setup.robot.name, clock, devices, release=board.disconnect)


def _open_device(drive: Drive | None, board: Board, clock: Clock, description: DeviceDescription) -> Device:
    match description:
        case MotorDescription():
            return BoardMotor(description, board, _find_wheel(description.name, drive), clock)
        case EncoderDescription():
            return BoardEncoder(description, board, _find_wheel(description.name, drive), clock)
        case RangeSensorDescription():
            return BoardRange(description, board, clock)
        case BatteryDescription():
            return BoardBattery(description, board, clock)
    raise DeviceError(description.name, f"the board has no {description.kind}")


def _find_wheel(device: str, drive: Drive | None) -> str:
    """Return ``left`` or ``right``, the wheel of a motor or an encoder."""
    if drive and device in (*drive.left_motors, *drive.left_encoders):
        return "left"
    if drive and device in (*drive.right_motors, *drive.right_encoders):
        return "right"
    raise DeviceError(device, "it belongs to no wheel. Name it in the section [drive] of the robot's file")
