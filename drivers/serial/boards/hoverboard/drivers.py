"""The settings and drivers of the devices of a hoverboard: two motors, two encoders, a battery."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field

from drivers.serial.boards.devices import BoardMotor
from drivers.serial.boards.drivers import BatteryDriver, BoardDriver, EncoderDriver, MotorDriver
from drivers.serial.boards.hoverboard.board import HoverboardProtocol
from drivers.serial.boards.hoverboard.protocol import LIMIT, STANDING, STOP, Mixer
from drivers.serial.driver import PortSettings, SideSettings
from robotcore.description import EncoderDescription, MotorDescription, RobotDescription
from robotcore.hal.devices import Motor
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
        return Mixer(self.speed_coefficient, self.steer_coefficient, self.tank_steering)

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


class HoverboardDriver(BoardDriver[Any, Any]):
    """The base class of the drivers of a hoverboard's devices."""

    protocol = HoverboardProtocol
    answer_s = 1.0  # a board sends feedback a hundred times a second
    stop, standing = STOP, STANDING


class HoverboardMotor(HoverboardDriver, MotorDriver[HoverboardMotorSettings]):
    """Opens motors. In mode "speed" the board controls the velocity. In mode "duty" the model gives the duty."""

    name = "hoverboard-motor"
    summary = "a wheel of a hoverboard with the FOC firmware"
    settings = HoverboardMotorSettings
    aliases = ("hoverboard", "eferu")

    def check(self, description: MotorDescription, settings: HoverboardMotorSettings, robot: RobotDescription) -> None:
        if settings.mode == "duty":
            _check_duty(description, settings, robot)
        elif settings.model or settings.control:
            raise ValueError("in mode speed the board controls the velocity; remove model and control")
        elif description.max_velocity_rad_s > (reach := settings.mixer.straight / abs(settings.unit_per_rad_s)):
            raise ValueError(
                f"the board turns a wheel at {reach:.3g} rad/s at most, but max_velocity_rad_s of {description.name} "
                f"is {description.max_velocity_rad_s:g}; lower it, or correct max_rpm or speed_coefficient"
            )

    def connections(self, settings: HoverboardMotorSettings) -> Sequence[Connection]:
        return (*super().connections(settings), settings.firmware())

    def notes(self, description: MotorDescription, settings: HoverboardMotorSettings) -> Sequence[str]:
        mode = MODE.format(mode="SPD_MODE" if settings.mode == "speed" else "VLT_MODE")
        scale = settings.mixer.turning / LIMIT
        return (WIRING, mode, SLEEPING, *((TURNING.format(scale=scale),) if scale < 1 else ()))

    def open(self, description: MotorDescription, settings: HoverboardMotorSettings, host: Host) -> Motor:
        self.open_board(description.name, settings, host).protocol.mixer = settings.mixer
        if settings.model is None:
            return BoardMotor(description, self.open_output(description, settings, host, settings.unit_per_rad_s))
        output = self.open_output(description, settings, host, settings.sign * LIMIT)
        return open_motor(description, settings.model, settings.control, lambda: output, host)


def _check_duty(description: MotorDescription, settings: HoverboardMotorSettings, robot: RobotDescription) -> None:
    if settings.model is None:
        raise ValueError("mode duty needs the model of the wheel; add a model, or build the firmware with SPD_MODE")
    if settings.model.max_duty > (straight := settings.mixer.straight / LIMIT):
        raise ValueError(
            f"the board's mixer reaches a duty of {straight:g} at most, but model.max_duty is "
            f"{settings.model.max_duty:g}; lower model.max_duty, or correct speed_coefficient"
        )
    require_drivable(description, settings.model, settings.control, robot)


class HoverboardEncoder(HoverboardDriver, EncoderDriver[WheelSettings]):
    """Opens encoders. The angle is the integral of the measured speed, because the board sends no angle."""

    name = "hoverboard-encoder"
    summary = "the angle of a hoverboard's wheel, integrated from its measured speed"
    settings = WheelSettings

    def rad_per_unit(self, description: EncoderDescription, settings: WheelSettings, robot: RobotDescription) -> float:
        forward = 1 if settings.side == "left" else -1  # the right motor is mounted the other way round
        return forward * settings.sign * math.tau / 60


class HoverboardBattery(HoverboardDriver, BatteryDriver[HoverboardSettings]):
    """Opens the battery, whose voltage the board measures with a resolution of 0.01 V."""

    name = "hoverboard-battery"
    summary = "the battery of a hoverboard"
    settings = HoverboardSettings
