"""Motors on a Sabertooth or SyRen."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Annotated, ClassVar

from pydantic import Field

from drivers.serial.boards.board import open_board
from drivers.serial.boards.cutoff import stop_frame
from drivers.serial.boards.devices import BoardOutput
from drivers.serial.boards.sabertooth.board import SETTLING_S, SabertoothProtocol
from drivers.serial.boards.sabertooth.protocol import HIGHEST_ADDRESS, LOWEST_ADDRESS, MotorNumber, stop
from drivers.serial.driver import SerialDriver, Side, TimeoutSettings
from robotcore.description import MotorDescription, RobotDescription
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Motor
from robotcore.hardware import Connection, Host
from robotcore.hardware.motor_control import Control, open_motor, require_drivable
from robotcore.hardware.motor_model import Model

BAUDS = (2400, 9600, 19200, 38400, 115200)
"""The rates that some Sabertooth knows."""

SIDES: dict[MotorNumber, Side] = {1: "left", 2: "right"}
"""As which of a board's two motors each goes in its command."""

WIRING = (
    "The adapter's TX (5 V or 3.3 V) goes to S1 and its ground to 0V; nothing comes back. The switches are set to "
    "packetized serial and the board's address."
)
UNHEARD = (
    "The board never answers: whether it is there, is switched on and has heard a command nobody can tell, unless the "
    "wheels have encoders."
)
SWITCHING_ON = (
    "Switch its battery on two seconds before the program starts, and start the program anew where it was off since: "
    "the board takes its baud rate from the first byte that it hears. Where a wheel turns the wrong way, swap its "
    "motor's two wires."
)


class SabertoothSettings(TimeoutSettings):
    """The board's address, the motor's number on it, and how fast it turns by which duty."""

    speaks: ClassVar[str] = "Sabertooth packet serial"
    usual_baud: ClassVar[int] = 9600
    is_mute: ClassVar[bool] = True

    address: Annotated[int, Field(ge=LOWEST_ADDRESS, le=HIGHEST_ADDRESS)] = LOWEST_ADDRESS
    motor: MotorNumber
    model: Model
    control: Control | None = None


class SabertoothMotor(SerialDriver[MotorDescription, SabertoothSettings]):
    """Sends duties, in 127 steps each way."""

    name = "sabertooth-motor"
    summary = "a motor on a Sabertooth or SyRen in packet serial mode"
    described = MotorDescription
    what = "motor"
    settings = SabertoothSettings
    aliases = ("sabertooth", "syren", "dimension engineering")
    reports_direction = True

    def check(self, description: MotorDescription, settings: SabertoothSettings, robot: RobotDescription) -> None:
        if settings.speed not in BAUDS:
            known = ", ".join(map(str, BAUDS))
            raise ValueError(f"no Sabertooth speaks at {settings.speed} baud; take one of {known}")
        require_drivable(description, settings.model, settings.control, robot)

    def connections(self, settings: SabertoothSettings) -> Sequence[Connection]:
        return settings.at(f"address {settings.address} M{settings.motor}")

    def notes(self, description: MotorDescription, settings: SabertoothSettings) -> Sequence[str]:
        return WIRING, UNHEARD, SWITCHING_ON

    def cutoffs(self, description: MotorDescription, settings: SabertoothSettings, host: Host) -> Sequence[CutoffSpec]:
        return (stop_frame(description.name, settings.port, settings.speed, stop(settings.address), None, host),)

    def open(self, description: MotorDescription, settings: SabertoothSettings, host: Host) -> Motor:
        make = partial(SabertoothProtocol, settings.speed)
        board = open_board(description.name, settings.port, SabertoothProtocol, make, host, 2 * SETTLING_S)
        command = board.protocol.board(settings.address, settings.board_timeout_s).command
        output = partial(BoardOutput, description.name, board.line, command, SIDES[settings.motor])
        return open_motor(description, settings.model, settings.control, output, host)
