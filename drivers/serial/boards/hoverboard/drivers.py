"""The drivers of the devices of a hoverboard: two motors, two encoders, a battery."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import Field

from drivers.serial.boards.drivers import BatteryDriver, BoardDriver, EncoderDriver, MotorDriver
from drivers.serial.boards.hoverboard.protocol import LIMIT, STANDING, STOP, HoverboardProtocol, Mixer
from robotcore.description import RobotDescription
from robotcore.hal.device_test import REVERSED
from robotcore.hardware import Connection, DeviceContext, Drivers
from robotcore.hardware.motor_control import Control, open_motor, require_drivable
from robotcore.hardware.motor_model import Model, OutputMotor
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.motor import Motor, MotorDescription

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


class HoverboardDriver(BoardDriver):
    """The base class of the drivers of a hoverboard's devices. The firmware's time-out is always 0.8 s."""

    protocol_name = "Hoverboard FOC"
    default_baud = 115200
    protocol = HoverboardProtocol
    answer_s = 1.0  # a board sends feedback a hundred times a second
    stop, standing = STOP, STANDING


class HoverboardMotor(HoverboardDriver, MotorDriver):
    """Opens motors. In mode "speed" the board controls the velocity. In mode "duty" the model gives the duty.

    Most of the settings repeat values of the firmware's config.h, because the board does not send these. Both motors of
    a board need the same values.
    """

    name = "hoverboard-motor"
    summary = "a wheel of a hoverboard with the FOC firmware"
    aliases = ("hoverboard", "eferu")

    inverted: bool = False
    """Whether the wheel's velocity changes its sign, because it turns the wrong way."""
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

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        return {"inverted": not self.inverted} if mistake == REVERSED else None

    @property
    def mixer(self) -> Mixer:
        return Mixer(self.speed_coefficient, self.steer_coefficient, self.tank_steering)

    @property
    def unit_per_rad_s(self) -> float:
        """The board's command value for 1 rad/s, in mode "speed"."""
        return LIMIT / self.max_rpm * 60 / math.tau

    def check(self, description: MotorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        if self.mode == "duty":
            self._check_duty(description, robot)
        elif self.model or self.control:
            raise ValueError("in mode speed the board controls the velocity; remove model and control")
        elif description.max_velocity_rad_s > (reach := self.mixer.straight / self.unit_per_rad_s / self.trim):
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

    def connections(self) -> Sequence[Connection]:
        """Return also a connection that two motors share, so that different firmware settings are a conflict."""
        settings = f"mode {self.mode}, {self.max_rpm} rpm, {self.mixer}"
        remedy = "give both motors the same mode, max_rpm and mixer settings"
        firmware = Connection("firmware", "config.h of the board at", self.port, True, remedy, settings)
        return (*super().connections(), firmware)

    def notes(self, description: MotorDescription) -> Sequence[str]:
        mode = MODE.format(mode="SPD_MODE" if self.mode == "speed" else "VLT_MODE")
        scale = self.mixer.turning / LIMIT
        return (WIRING, mode, SLEEPING, *((TURNING.format(scale=scale),) if scale < 1 else ()))

    def open(self, description: MotorDescription, context: DeviceContext) -> Motor:
        self.open_board(description.name, context).protocol.mixer = self.mixer
        unit = self.unit_per_rad_s if self.model is None else LIMIT
        output = self.open_output(description.name, context, -unit if self.inverted else unit)
        if self.model is None:
            return OutputMotor(description, output)
        return open_motor(description, self.model, self.control, lambda: output, context)


class HoverboardEncoder(HoverboardDriver, EncoderDriver):
    """Opens encoders. The angle is the integral of the measured speed, because the board sends no angle."""

    name = "hoverboard-encoder"
    summary = "the angle of a hoverboard's wheel, integrated from its measured speed"

    inverted: bool = False
    """Whether the wheel's angle changes its sign, because it counts the wrong way."""

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        return {"inverted": not self.inverted} if mistake == REVERSED else None

    def rad_per_unit(self, description: EncoderDescription, robot: RobotDescription) -> float:
        # The right motor is mounted the other way round.
        return math.tau / 60 * (1 if self.inverted == (self.side == "right") else -1)


class HoverboardBattery(HoverboardDriver, BatteryDriver):
    """Opens the battery, whose voltage the board measures with a resolution of 0.01 V."""

    name = "hoverboard-battery"
    summary = "the battery of a hoverboard"
