"""The driver of servos on a PCA9685."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

from pydantic import model_validator

from drivers.raspberrypi.pwm.boards import BOARDS, build_servo_settings
from drivers.raspberrypi.pwm.chip import PwmChip
from drivers.raspberrypi.pwm.settings import SUPPLY, Channel, ChannelDriver
from drivers.raspberrypi.servos import FRAME_HZ, PulseDriver, find_width
from robotcore.description import RobotDescription
from robotcore.errors import DeviceError
from robotcore.hardware import Connection, DeviceContext, Drivers
from robotcore.kinds.servo import Servo, ServoDescription


class ChannelServo(Servo):
    """A servo on a channel. After closing it gets no pulses."""

    def __init__(self, description: ServoDescription, driver: ChannelServoDriver, chip: PwmChip) -> None:
        super().__init__(description.name, **description.arguments())
        self._driver, self._chip = driver, chip

    def _apply(self, command: float) -> None:
        with self._driver.translate_errors(self.name):
            self._chip.set_pulse(self._driver.channel, find_width(self, self._driver.pulses, command))

    def _release(self) -> None:
        with self._driver.translate_errors(self.name):
            self._chip.set_duty(self._driver.channel, 0.0)


class ChannelServoDriver(ChannelDriver, PulseDriver):
    """Opens servos on a channel. An opened servo turns to its rest angle."""

    name = "pca9685-servo"
    summary = "a servo on a channel of a PCA9685"
    aliases = ("servokit",)

    board: str | None = None
    """The name of a board with connectors for servos, such as ``freenove-4wd``. It gives the address."""

    channel: Channel

    @model_validator(mode="before")
    @classmethod
    def _insert_board(cls, table: Any) -> Any:
        if not isinstance(table, Mapping) or "board" not in table:
            return table
        return {**build_servo_settings(table["board"], table.get("channel")), **table}

    @property
    def wanted_hz(self) -> int:
        return FRAME_HZ

    def connections(self) -> Sequence[Connection]:
        return (*super().connections(), self.connect("channel", self.channel))

    def notes(self, description: ServoDescription) -> Sequence[str]:
        if self.board is None:
            return (SUPPLY, *super().notes(description))
        board = BOARDS[self.board]
        return f"Connect the servo to the connector of channel {self.channel} on the {board.title}.", board.note

    def check(self, description: ServoDescription, robot: RobotDescription, drivers: Drivers) -> None:
        super().check(description, robot, drivers)
        self.require_one_frequency(drivers)

    def open(self, description: ServoDescription, context: DeviceContext) -> Servo:
        servo = ChannelServo(description, self, self.take_chip(description.name, context))
        try:
            servo.set_angle(servo.angle)
        except DeviceError:
            with suppress(DeviceError):
                servo.close()
            raise
        return servo
