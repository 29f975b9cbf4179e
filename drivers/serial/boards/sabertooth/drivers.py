"""The driver of motors on a Sabertooth or SyRen."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Annotated, ClassVar

from pydantic import Field

from drivers.serial.boards.board import open_board
from drivers.serial.boards.cutoff import stop_frame
from drivers.serial.boards.devices import BoardOutput
from drivers.serial.boards.sabertooth.protocol import (
    HIGHEST_ADDRESS,
    LOWEST_ADDRESS,
    SETTLING_S,
    MotorNumber,
    SabertoothProtocol,
    stop,
)
from drivers.serial.driver import SerialDriver, Side, TimeoutSettings
from robotcore.description import MotorDescription, RobotDescription
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Motor
from robotcore.hardware import Connection, Host
from robotcore.hardware.motor_control import Control, open_motor, require_drivable
from robotcore.hardware.motor_model import Model

BAUDS = (2400, 9600, 19200, 38400, 115200)
"""The baud rates of all Sabertooth models. Each model has some of them."""

SIDES: dict[MotorNumber, Side] = {1: "left", 2: "right"}
"""The side of each motor in a `WheelCommand`."""

WIRING = (
    "The adapter's TX (5 V or 3.3 V) goes to S1 and its ground to 0V; the board sends nothing. Set the switches to "
    "packetized serial and the board's address."
)
UNHEARD = (
    "The board never answers. Without encoders on the wheels, robotcore cannot detect whether the board is "
    "connected, is switched on and has received a command."
)
SWITCHING_ON = (
    "Switch the board's battery on two seconds before the program starts. Restart the program if the battery was off. "
    "The board takes its baud rate from the first byte that it receives. If a wheel turns the wrong way, swap its "
    "motor's two wires."
)


class SabertoothSettings(TimeoutSettings):
    """The settings of a motor on a Sabertooth."""

    protocol_name: ClassVar[str] = "Sabertooth packet serial"
    default_baud: ClassVar[int] = 9600
    is_mute: ClassVar[bool] = True

    address: Annotated[int, Field(ge=LOWEST_ADDRESS, le=HIGHEST_ADDRESS)] = LOWEST_ADDRESS
    motor: MotorNumber
    model: Model
    """The velocity of the wheel at each duty."""
    control: Control | None = None
    """The settings of velocity control by the wheel's encoder. If it is None, the model alone gives the duty."""


class SabertoothMotor(SerialDriver[MotorDescription, SabertoothSettings]):
    """Opens motors, whose duty has 127 steps in each direction."""

    name = "sabertooth-motor"
    summary = "a motor on a Sabertooth or SyRen in packet serial mode"
    described = MotorDescription
    part = "motor"
    settings = SabertoothSettings
    aliases = ("sabertooth", "syren", "dimension engineering")
    reports_direction = True

    def check(self, description: MotorDescription, settings: SabertoothSettings, robot: RobotDescription) -> None:
        if settings.speed not in BAUDS:
            known = ", ".join(map(str, BAUDS))
            raise ValueError(f"no Sabertooth has {settings.speed} baud; use one of {known}")
        require_drivable(description, settings.model, settings.control, robot)

    def connections(self, settings: SabertoothSettings) -> Sequence[Connection]:
        return settings.connections(f"address {settings.address} M{settings.motor}")

    def notes(self, description: MotorDescription, settings: SabertoothSettings) -> Sequence[str]:
        return WIRING, UNHEARD, SWITCHING_ON

    def cutoffs(self, description: MotorDescription, settings: SabertoothSettings, host: Host) -> Sequence[CutoffSpec]:
        return (stop_frame(description.name, settings, stop(settings.address), None, host),)

    def open(self, description: MotorDescription, settings: SabertoothSettings, host: Host) -> Motor:
        board = open_board(description.name, settings, SabertoothProtocol, host, 2 * SETTLING_S)
        command = board.protocol.board(settings.address, settings.board_timeout_s).command
        output = partial(BoardOutput, description.name, board.line, command, SIDES[settings.motor])
        return open_motor(description, settings.model, settings.control, output, host)
