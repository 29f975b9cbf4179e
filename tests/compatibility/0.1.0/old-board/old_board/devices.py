"""The devices of a robot on the board. robotcore calls the methods whose names begin with an underscore."""

import math

from robotcore.hal.clock import Clock
from robotcore.kinds.battery import Battery, BatteryDescription, Voltage
from robotcore.kinds.encoder import Angle, Encoder, EncoderDescription
from robotcore.kinds.motor import Motor, MotorDescription
from robotcore.kinds.range_sensor import Range, RangeSensor, RangeSensorDescription

from old_board.board import Board
from old_board.commands import CommandSender
from old_board.error_translation import translate_errors
from old_board.polling import PolledSensor


class BoardMotor(Motor):
    """The motor of a wheel."""

    def __init__(self, description: MotorDescription, board: Board, wheel: str, clock: Clock) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._sender = CommandSender(self.name, clock, lambda rad_s: board.turn(wheel, rad_s))

    def _apply(self, rad_s: float) -> None:
        self._sender.put(rad_s)

    def _release(self) -> None:
        self._sender.stop()


class BoardEncoder(Encoder):
    """The encoder of a wheel. Its angle is zero when it is opened."""

    def __init__(self, description: EncoderDescription, board: Board, wheel: str, clock: Clock) -> None:
        super().__init__(description.name)
        self._board, self._wheel = board, wheel
        with translate_errors(self.name):
            self._zero = board.angle(wheel)
        self._polled = PolledSensor(self.name, clock, self._read_board)

    def _newest(self) -> Angle:
        return self._polled.newest()

    def _read_board(self, time: float, sequence: int) -> Angle:
        return Angle(self._board.angle(self._wheel) - self._zero, time, sequence)

    def _release(self) -> None:
        self._polled.stop()


class BoardRange(RangeSensor):
    """The range sensor."""

    def __init__(self, description: RangeSensorDescription, board: Board, clock: Clock) -> None:
        super().__init__(
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._board, self._mount_x = board, description.mount.x_m
        self._polled = PolledSensor(self.name, clock, self._read_board)

    def _newest(self) -> Range:
        return self._polled.newest()

    def _read_board(self, time: float, sequence: int) -> Range:
        distance = max(self._board.distance() - self._mount_x, self.min_range)
        return Range(distance if distance <= self.max_range else math.inf, time, sequence)

    def _release(self) -> None:
        self._polled.stop()


class BoardBattery(Battery):
    """The battery of the board. If it cannot be read, the run continues."""

    def __init__(self, description: BatteryDescription, board: Board, clock: Clock) -> None:
        super().__init__(description.name)
        self._board = board
        self._polled = PolledSensor(self.name, clock, self._read_board)

    def _newest(self) -> Voltage:
        return self._polled.newest()

    def _read_board(self, time: float, sequence: int) -> Voltage:
        return Voltage(self._board.voltage(), time, sequence)

    def _release(self) -> None:
        self._polled.stop()
