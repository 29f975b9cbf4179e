"""The settings and drivers of a hoverboard's devices: two motors, two wheels' speeds, a battery."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from drivers.serial.boards.board import Board, open_board
from drivers.serial.boards.command import CommandBuffer
from drivers.serial.boards.cutoff import stop_frame
from drivers.serial.boards.devices import BoardBattery, BoardEncoder, BoardMotor, BoardOutput
from drivers.serial.boards.hoverboard.board import HoverboardProtocol
from drivers.serial.boards.hoverboard.protocol import LIMIT, STANDING, STOP, CoefficientMixer, Mixer, TankMixer
from drivers.serial.driver import PortSettings, SerialDriver, Side, SideSettings
from drivers.serial.line import Line
from robotcore.description import BatteryDescription, EncoderDescription, MotorDescription, RobotDescription
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Battery, Encoder, Motor
from robotcore.hardware import Connection, Host
from robotcore.hardware.motor_control import Control, open_motor, require_drivable
from robotcore.hardware.motor_model import Model


class HoverboardSettings(PortSettings):
    """The port; the board's own time-out is in its firmware (SERIAL_TIMEOUT, 0.8 s) and cannot be set."""

    speaks: ClassVar[str] = "Hoverboard FOC"
    usual_baud: ClassVar[int] = 115200


class WheelSettings(SideSettings, HoverboardSettings):
    """One of the board's two wheels; ``inverted`` where its driver turns or counts it the wrong way."""

    inverted: bool = False

    @property
    def sign(self) -> int:
        return -1 if self.inverted else 1


class HoverboardMotorSettings(WheelSettings):
    """What the firmware was built with, by its config.h: the driver cannot ask, and the two motors say the same.

    ``mode`` is CTRL_MOD_REQ: "speed" is SPD_MODE, where the board holds the velocity and ``max_rpm`` is N_MOT_MAX;
    "duty" is VLT_MODE, where the wheel turns by ``model``, and ``control`` by its encoder. ``tank_steering`` is whether
    TANK_STEERING is defined; where it is not, ``speed_coefficient`` and ``steer_coefficient`` are those of the mixer,
    divided by 16384.
    """

    mode: Literal["speed", "duty"]
    max_rpm: Annotated[int, Field(ge=10, le=2000)] = 1000
    tank_steering: bool = False
    speed_coefficient: Annotated[float, Field(ge=0.1, lt=2)] = 1.0
    steer_coefficient: Annotated[float, Field(ge=0.1, lt=2)] = 0.5
    model: Model | None = None
    control: Control | None = None

    @property
    def mixer(self) -> Mixer:
        return TankMixer() if self.tank_steering else CoefficientMixer(self.speed_coefficient, self.steer_coefficient)

    @property
    def unit_per_rad_s(self) -> float:
        """What the board is told for 1 rad/s in its own closed loop."""
        return self.sign * LIMIT / self.max_rpm * 60 / math.tau

    def firmware(self) -> Connection:
        """Return what both motors of a board must say alike, as something that they share."""
        built = f"mode {self.mode}, {self.max_rpm} rpm, {self.mixer}"
        instead = "say the same of it for both motors"
        return Connection(
            "firmware", "config.h of the board at", self.port, is_shared=True, instead=instead, protocol=built
        )

    def check(self, description: MotorDescription, robot: RobotDescription) -> None:
        """Raise ValueError, the fault, a semicolon and the remedy, where the board cannot turn the wheel so."""
        if self.mode == "duty":
            self._check_duty(description, robot)
        elif self.model or self.control:
            raise ValueError("in mode speed the board holds the velocity; leave model and control out")
        elif description.max_velocity_rad_s > (reach := self.mixer.straight / abs(self.unit_per_rad_s)):
            raise ValueError(
                f"the board turns a wheel at {reach:.3g} rad/s at most, and max_velocity_rad_s of {description.name} "
                f"is {description.max_velocity_rad_s:g}; lower that, or correct max_rpm or speed_coefficient"
            )

    def _check_duty(self, description: MotorDescription, robot: RobotDescription) -> None:
        if self.model is None:
            raise ValueError("in mode duty the wheel turns by its model; add one, or build the board with SPD_MODE")
        if self.model.max_duty > (straight := self.mixer.straight / LIMIT):
            raise ValueError(
                f"the board's mixer makes a duty of {straight:g} at most, and model.max_duty is "
                f"{self.model.max_duty:g}; lower that, or correct speed_coefficient"
            )
        require_drivable(description, self.model, self.control, robot)


ANSWER_S = 1.0
"""A board that is on tells a hundred times a second."""

WIRING = (
    "A sensor board's cable of the hoverboard: its RX, TX (3.3 V) and ground go to the adapter, and never its red "
    "wire, which has 15 V. The firmware is VARIANT_USART, with CONTROL_SERIAL and FEEDBACK_SERIAL on that cable."
)
SLEEPING = "A board whose wheels stood for 8 minutes (INACTIVITY_TIMEOUT) switches itself off; its button wakes it."
MODE = "Its config.h must have CTRL_MOD_REQ {mode}: the board does not tell which one it has."
TURNING = (
    "By its steer_coefficient it turns wheels against each other at {part:.0%} of its most: where more is asked for, "
    "both turn slower alike and the path stays. TANK_STEERING has no such limit."
)


class HoverboardMotor(SerialDriver[MotorDescription, HoverboardMotorSettings]):
    """Turns a wheel by the board's own closed loop, or by duty and the wheel's model."""

    name = "hoverboard-motor"
    summary = "a wheel of a hoverboard with the FOC firmware"
    described = MotorDescription
    what = "motor"
    settings = HoverboardMotorSettings
    aliases = ("hoverboard", "eferu")

    def check(self, description: MotorDescription, settings: HoverboardMotorSettings, robot: RobotDescription) -> None:
        settings.check(description, robot)

    def connections(self, settings: HoverboardMotorSettings) -> Sequence[Connection]:
        return (*super().connections(settings), settings.firmware())

    def notes(self, description: MotorDescription, settings: HoverboardMotorSettings) -> Sequence[str]:
        mode = MODE.format(mode="SPD_MODE" if settings.mode == "speed" else "VLT_MODE")
        part = settings.mixer.turning / LIMIT
        return (WIRING, mode, SLEEPING, *((TURNING.format(part=part),) if part < 1 else ()))

    def cutoffs(
        self, description: MotorDescription, settings: HoverboardMotorSettings, host: Host
    ) -> Sequence[CutoffSpec]:
        return (stop_frame(description.name, settings.port, settings.speed, STOP, STANDING, host),)

    def open(self, description: MotorDescription, settings: HoverboardMotorSettings, host: Host) -> Motor:
        board = _board(description.name, settings, host)
        board.protocol.mixer = settings.mixer
        if settings.model is None:
            output = BoardOutput(description.name, board.line, board.protocol.command, settings.side)
            return BoardMotor(description, output, settings.unit_per_rad_s)
        duties = DutyOutput(description.name, board.line, board.protocol.command, settings.side, settings.sign * LIMIT)
        return open_motor(description, settings.model, settings.control, lambda: duties, host)


class DutyOutput(BoardOutput):
    """A side of the board that takes duties; ``unit`` is what the board is told for a whole one."""

    def __init__(self, device: str, line: Line, command: CommandBuffer, side: Side, unit: int) -> None:
        super().__init__(device, line, command, side)
        self._unit = unit

    def turn(self, duty: float) -> None:
        super().turn(duty * self._unit)


class HoverboardEncoder(SerialDriver[EncoderDescription, WheelSettings]):
    """Adds up the speed that the board measures: an estimate, for it tells no angle."""

    name = "hoverboard-encoder"
    summary = "the turns of a hoverboard's wheel, by its measured speed"
    described = EncoderDescription
    what = "encoder"
    settings = WheelSettings

    def open(self, description: EncoderDescription, settings: WheelSettings, host: Host) -> Encoder:
        board = _board(description.name, settings, host)
        is_left = settings.side == "left"
        forward = 1 if is_left else -1  # the right motor is mounted the other way round
        turning = board.protocol.left if is_left else board.protocol.right
        encoder = BoardEncoder(description.name, board.line, turning, forward * settings.sign * math.tau / 60)
        encoder.await_first(ANSWER_S)
        return encoder


class HoverboardBattery(SerialDriver[BatteryDescription, HoverboardSettings]):
    """The voltage that the board measures, in hundredths of a volt."""

    name = "hoverboard-battery"
    summary = "the battery of a hoverboard"
    described = BatteryDescription
    what = "battery"
    settings = HoverboardSettings

    def open(self, description: BatteryDescription, settings: HoverboardSettings, host: Host) -> Battery:
        board = _board(description.name, settings, host)
        battery = BoardBattery(description.name, board.line, lambda: board.protocol.voltage)
        battery.await_first(ANSWER_S)
        return battery


def _board(device: str, settings: HoverboardSettings, host: Host) -> Board[HoverboardProtocol]:
    return open_board(
        device, settings.port, HoverboardProtocol, partial(HoverboardProtocol, settings.speed), host, ANSWER_S
    )
