"""The settings and drivers of the devices of a hoverboard: two motors, two encoders, a battery."""

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
    """The settings of a device of a hoverboard. The firmware's time-out is always 0.8 s, so there is no setting."""

    protocol_name: ClassVar[str] = "Hoverboard FOC"
    default_baud: ClassVar[int] = 115200


class WheelSettings(SideSettings, HoverboardSettings):
    """The settings of a device on one of the board's two wheels."""

    inverted: bool = False
    """Whether the wheel's velocity and angle change their sign, because it turns or counts the wrong way."""

    @property
    def sign(self) -> int:
        return -1 if self.inverted else 1


class HoverboardMotorSettings(WheelSettings):
    """The settings of a motor of a hoverboard.

    Most of them repeat values of the firmware's config.h, because the board does not send these. Both motors of a board
    need the same values.
    """

    mode: Literal["speed", "duty"]
    """CTRL_MOD_REQ in config.h: "speed" is SPD_MODE, in which the board controls the velocity; "duty" is VLT_MODE."""
    max_rpm: Annotated[int, Field(ge=10, le=2000)] = 1000
    """N_MOT_MAX in config.h: the wheel's speed at the highest command value, in rpm."""
    tank_steering: bool = False
    """Whether TANK_STEERING is defined in config.h."""
    speed_coefficient: Annotated[float, Field(ge=0.1, lt=2)] = 1.0
    """SPEED_COEFFICIENT in config.h, divided by 16384. TANK_STEERING does not use it."""
    steer_coefficient: Annotated[float, Field(ge=0.1, lt=2)] = 0.5
    """STEER_COEFFICIENT in config.h, divided by 16384. TANK_STEERING does not use it."""
    model: Model | None = None
    """The velocity of the wheel at each duty, for mode "duty"."""
    control: Control | None = None
    """The settings of velocity control by the wheel's encoder, for mode "duty"."""

    @property
    def mixer(self) -> Mixer:
        return TankMixer() if self.tank_steering else CoefficientMixer(self.speed_coefficient, self.steer_coefficient)

    @property
    def unit_per_rad_s(self) -> float:
        """The board's command value for 1 rad/s, in mode "speed"."""
        return self.sign * LIMIT / self.max_rpm * 60 / math.tau

    def firmware(self) -> Connection:
        """Return a connection that two motors of a board share, so that different firmware settings are a conflict."""
        settings = f"mode {self.mode}, {self.max_rpm} rpm, {self.mixer}"
        remedy = "give both motors the same mode, max_rpm and mixer settings"
        return Connection(
            "firmware", "config.h of the board at", self.port, is_shared=True, remedy=remedy, protocol=settings
        )

    def check(self, description: MotorDescription, robot: RobotDescription) -> None:
        """Raise ValueError if the board cannot reach the maximum velocity, or if a setting contradicts the mode."""
        if self.mode == "duty":
            self._check_duty(description, robot)
        elif self.model or self.control:
            raise ValueError("in mode speed the board controls the velocity; remove model and control")
        elif description.max_velocity_rad_s > (reach := self.mixer.straight / abs(self.unit_per_rad_s)):
            raise ValueError(
                f"the board turns a wheel at {reach:.3g} rad/s at most, but max_velocity_rad_s of {description.name} "
                f"is {description.max_velocity_rad_s:g}; lower it, or correct max_rpm or speed_coefficient"
            )

    def _check_duty(self, description: MotorDescription, robot: RobotDescription) -> None:
        if self.model is None:
            raise ValueError("mode duty needs the model of the wheel; add a model, or build the firmware with SPD_MODE")
        if self.model.max_duty > (straight := self.mixer.straight / LIMIT):
            raise ValueError(
                f"the board's mixer reaches a duty of {straight:g} at most, but model.max_duty is "
                f"{self.model.max_duty:g}; lower model.max_duty, or correct speed_coefficient"
            )
        require_drivable(description, self.model, self.control, robot)


ANSWER_S = 1.0
"""The longest wait for the first feedback, in seconds. A board sends feedback a hundred times a second."""

WIRING = (
    "Use the cable of one of the hoverboard's sensor boards. Connect its RX, TX (3.3 V) and ground to the adapter, but "
    "never its red wire, which has 15 V. The firmware is VARIANT_USART, with CONTROL_SERIAL and FEEDBACK_SERIAL on "
    "that cable."
)
SLEEPING = "A board whose wheels stand for 8 minutes (INACTIVITY_TIMEOUT) switches off; its button switches it on."
MODE = "The board's config.h must have CTRL_MOD_REQ {mode}, because the board does not send its mode."
TURNING = (
    "With this steer_coefficient, wheels that turn against each other reach {scale:.0%} of their full speed. In a "
    "faster turn both wheels are slowed down, so that the curve stays the same. TANK_STEERING has no such limit."
)


class HoverboardMotor(SerialDriver[MotorDescription, HoverboardMotorSettings]):
    """Opens motors. In mode "speed" the board controls the velocity. In mode "duty" the model gives the duty."""

    name = "hoverboard-motor"
    summary = "a wheel of a hoverboard with the FOC firmware"
    described = MotorDescription
    part = "motor"
    settings = HoverboardMotorSettings
    aliases = ("hoverboard", "eferu")

    def check(self, description: MotorDescription, settings: HoverboardMotorSettings, robot: RobotDescription) -> None:
        settings.check(description, robot)

    def connections(self, settings: HoverboardMotorSettings) -> Sequence[Connection]:
        return (*super().connections(settings), settings.firmware())

    def notes(self, description: MotorDescription, settings: HoverboardMotorSettings) -> Sequence[str]:
        mode = MODE.format(mode="SPD_MODE" if settings.mode == "speed" else "VLT_MODE")
        scale = settings.mixer.turning / LIMIT
        return (WIRING, mode, SLEEPING, *((TURNING.format(scale=scale),) if scale < 1 else ()))

    def cutoffs(
        self, description: MotorDescription, settings: HoverboardMotorSettings, host: Host
    ) -> Sequence[CutoffSpec]:
        return (stop_frame(description.name, settings.port, settings.speed, STOP, STANDING, host),)

    def open(self, description: MotorDescription, settings: HoverboardMotorSettings, host: Host) -> Motor:
        board = _open_board(description.name, settings, host)
        board.protocol.mixer = settings.mixer
        if settings.model is None:
            output = BoardOutput(description.name, board.line, board.protocol.command, settings.side)
            return BoardMotor(description, output, settings.unit_per_rad_s)
        duties = DutyOutput(description.name, board.line, board.protocol.command, settings.side, settings.sign * LIMIT)
        return open_motor(description, settings.model, settings.control, lambda: duties, host)


class DutyOutput(BoardOutput):
    """The output to one motor of a board in mode "duty". ``unit`` is the board's command value for the duty 1."""

    def __init__(self, device: str, line: Line, command: CommandBuffer, side: Side, unit: int) -> None:
        super().__init__(device, line, command, side)
        self._unit = unit

    def turn(self, duty: float) -> None:
        super().turn(duty * self._unit)


class HoverboardEncoder(SerialDriver[EncoderDescription, WheelSettings]):
    """Opens encoders. The angle is the integral of the measured speed, because the board sends no angle."""

    name = "hoverboard-encoder"
    summary = "the angle of a hoverboard's wheel, integrated from its measured speed"
    described = EncoderDescription
    part = "encoder"
    settings = WheelSettings

    def open(self, description: EncoderDescription, settings: WheelSettings, host: Host) -> Encoder:
        board = _open_board(description.name, settings, host)
        is_left = settings.side == "left"
        forward = 1 if is_left else -1  # the right motor is mounted the other way round
        counter = board.protocol.left if is_left else board.protocol.right
        encoder = BoardEncoder(description.name, board.line, counter, forward * settings.sign * math.tau / 60)
        encoder.await_first(ANSWER_S)
        return encoder


class HoverboardBattery(SerialDriver[BatteryDescription, HoverboardSettings]):
    """Opens the battery, whose voltage the board measures with a resolution of 0.01 V."""

    name = "hoverboard-battery"
    summary = "the battery of a hoverboard"
    described = BatteryDescription
    part = "battery"
    settings = HoverboardSettings

    def open(self, description: BatteryDescription, settings: HoverboardSettings, host: Host) -> Battery:
        board = _open_board(description.name, settings, host)
        battery = BoardBattery(description.name, board.line, lambda: board.protocol.voltage)
        battery.await_first(ANSWER_S)
        return battery


def _open_board(device: str, settings: HoverboardSettings, host: Host) -> Board[HoverboardProtocol]:
    return open_board(
        device, settings.port, HoverboardProtocol, partial(HoverboardProtocol, settings.speed), host, ANSWER_S
    )
