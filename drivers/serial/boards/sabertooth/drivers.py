"""The driver of motors on a Sabertooth or SyRen."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Annotated

from pydantic import Field

from drivers.serial.boards.devices import BoardOutput
from drivers.serial.boards.drivers import BoardDriver, BoardTimeout
from drivers.serial.boards.sabertooth.protocol import (
    FULL_DUTY,
    HIGHEST_ADDRESS,
    LOWEST_ADDRESS,
    SETTLING_S,
    MotorNumber,
    SabertoothProtocol,
    build_stop_packets,
)
from drivers.serial.driver import Side
from robotcore.description import RobotDescription
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hardware import DeviceContext, Drivers
from robotcore.hardware.motor_control import Control, open_motor, require_drivable
from robotcore.hardware.motor_model import Model
from robotcore.kinds.motor import Motor, MotorDescription

BAUDS = (2400, 9600, 19200, 38400, 115200)
"""The baud rates of all Sabertooth models. Each model has some of them."""

SIDES: dict[MotorNumber, Side] = {1: "left", 2: "right"}
"""The side of each motor in a `WheelCommand`."""

WIRING = (
    "The adapter's TX (5 V or 3.3 V) goes to S1 and its ground to 0V; the board sends nothing. Set the switches to "
    "packetized serial and the board's address."
)
NO_ANSWER_NOTE = (
    "The board never answers. Without encoders on the wheels, robotcore cannot detect whether the board is "
    "connected, is switched on and has received a command."
)
SWITCHING_ON = (
    "Switch the board's battery on two seconds before the program starts. Restart the program if the battery was off. "
    "The board takes its baud rate from the first byte that it receives. If a wheel turns the wrong way, swap its "
    "motor's two wires."
)


class SabertoothMotor(BoardDriver):
    """Opens motors, whose duty has 127 steps in each direction."""

    name = "sabertooth-motor"
    summary = "a motor on a Sabertooth or SyRen in packet serial mode"
    described = MotorDescription
    aliases = ("sabertooth", "syren", "dimension engineering")
    reports_direction = True
    duty_steps = FULL_DUTY
    protocol_name = "Sabertooth packet serial"
    default_baud = 9600
    is_mute = True
    part_key = "motor"
    protocol = SabertoothProtocol
    answer_s = 2 * SETTLING_S

    address: Annotated[int, Field(ge=LOWEST_ADDRESS, le=HIGHEST_ADDRESS)] = LOWEST_ADDRESS
    motor: MotorNumber
    board_timeout_s: BoardTimeout = 0.5
    model: Model
    """The velocity of the wheel at each duty."""
    control: Control | None = None
    """The settings of velocity control by the wheel's encoder. If it is None, the model alone gives the duty."""

    @property
    def part(self) -> str:
        return f"address {self.address} M{self.motor}"

    def check(self, description: MotorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if self.effective_baud not in BAUDS:
            known = ", ".join(map(str, BAUDS))
            raise ValueError(f"a Sabertooth does not support {self.effective_baud} baud; use one of {known}")
        require_drivable(description, self.model, self.control, robot)

    def notes(self, description: MotorDescription) -> Sequence[str]:
        return WIRING, NO_ANSWER_NOTE, SWITCHING_ON

    def cutoffs(self, description: MotorDescription, context: DeviceContext) -> Sequence[CutoffSpec]:
        return (self.stop_frame(description.name, build_stop_packets(self.address), None, context),)

    def open(self, description: MotorDescription, context: DeviceContext) -> Motor:
        board = self.open_board(description.name, context)
        command = board.protocol.board(self.address, self.board_timeout_s).command
        output = partial(BoardOutput, description.name, board.line, command, SIDES[self.motor])
        return open_motor(description, self.model, self.control, output, context)
