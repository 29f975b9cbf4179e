"""The drivers of an Arduino's devices."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar

from drivers.serial.boards.board import Board
from drivers.serial.boards.devices import BoardBattery
from drivers.serial.boards.drivers import BatteryDriver, BoardDriver, EncoderDriver, MotorDriver
from drivers.serial.boards.rosarduino.board import ArduinoProtocol
from drivers.serial.boards.rosarduino.devices import MUTE_PINGS, CountingMotor, Pings, Ranges
from drivers.serial.boards.rosarduino.protocol import PING_S, RANGE, STOP_CONFIRMED, STOP_NOW, ping
from drivers.serial.boards.rosarduino.requests import VERSION
from drivers.serial.boards.rosarduino.settings import (
    BOARD,
    COUNTING,
    EDGES,
    ENCODER,
    PINGING,
    TIMEOUT,
    UNPINNED,
    ArduinoEncoderSettings,
    ArduinoMotorSettings,
    ArduinoSettings,
    ArduinoSonarSettings,
    counts_per_turn,
    edges_per_turn,
    require_countable,
)
from drivers.serial.ranging.sensor import LineRangeSensor
from robotcore.description import (
    BatteryDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    RobotDescription,
)
from robotcore.errors import DeviceError
from robotcore.hal.devices import Battery, Encoder, Motor, RangeSensor, Voltage
from robotcore.hardware import Connection, Host
from robotcore.hardware.motor_control import open_motor, require_drivable
from robotcore.hardware.polled_samples import RangeSampler, require_timely

COUNT_S = 0.005
"""The period of requesting encoder counts, in seconds; equal to the shortest period of velocity control."""

RANGE_S = 0.03
"""The period of requesting the range from robotcore_bridge, in seconds."""

FLASH = "flash robotcore_bridge: robotcore firmware flash"

NOT_WIRED = (
    "the board's firmware was built without a battery; set BATTERY_PIN in config.h to the pin of its divider, and "
    "flash it again"
)


class ArduinoDriver(BoardDriver[Any, Any]):
    """The base class of the drivers of an Arduino's devices."""

    aliases: ClassVar[tuple[str, ...]] = ("arduino", "uno", "nano", "robotcore-bridge", "rosarduinobridge")
    protocol = ArduinoProtocol
    answer_s = 4.0  # opening the port resets an Arduino, and its boot loader waits up to two seconds for a new sketch
    stop, standing = STOP_NOW, STOP_CONFIRMED

    def notes(self, description: Any, settings: Any) -> Sequence[str]:
        return (BOARD,)

    def open_board(self, device: str, settings: ArduinoSettings, host: Host) -> Board[ArduinoProtocol]:
        board: Board[ArduinoProtocol] = super().open_board(device, settings, host)
        if (version := board.protocol.firmware.version) != VERSION:
            problem = f"its firmware has version {version} of the protocol, and this robotcore supports {VERSION}"
            remedy = "flash the firmware of this robotcore: robotcore firmware flash"
            place = board.line.place
            raise DeviceError(
                device,
                f"the board on {place} is not supported: {problem}; {remedy}",
                kind="firmware-version",
                place=place,
            )
        return board

    def open_board_with_wheels(self, device: str, settings: ArduinoSettings, host: Host) -> Board[ArduinoProtocol]:
        """Return the board of a motor or an encoder; raises DeviceError if its firmware was built without wheels."""
        board = self.open_board(device, settings, host)
        if not board.protocol.firmware.has_wheels:
            place = board.line.place
            problem = f"the ROSArduinoBridge on {place} was built without wheels"
            remedy = f"Define USE_BASE and flash it again, or {FLASH}"
            raise DeviceError(device, f"{problem}. {remedy}", kind="board-without-wheels", place=place)
        return board


def require_robotcore_bridge(board: Board[ArduinoProtocol], device: str, lacks: str, instead: str = "") -> None:
    """Raise DeviceError if the board does not run robotcore_bridge.

    lacks: the missing ability of ROSArduinoBridge, for the message, such as ``measures no battery``.
    instead: a remedy other than flashing robotcore_bridge; empty if there is none.
    """
    if not board.protocol.firmware.is_robotcore_bridge:
        place = board.line.place
        remedy = f"{instead}, or {FLASH}" if instead else FLASH
        text = f"the board on {place} runs ROSArduinoBridge, which {lacks}. {remedy[0].upper()}{remedy[1:]}"
        raise DeviceError(device, text, kind="firmware-lacks", place=place, lacks=lacks)


class ArduinoMotor(ArduinoDriver, MotorDriver[ArduinoMotorSettings]):
    """Opens motors on an Arduino. A motor with a model gets duties; without a model, the board controls its velocity.

    The driver sets the time-out of robotcore_bridge. The time-out of ROSArduinoBridge is always 2 s.
    """

    name = "ros-arduino-motor"
    summary = "a motor on an Arduino with ROSArduinoBridge or robotcore_bridge, on a serial line"
    settings = ArduinoMotorSettings
    reports_direction = True

    def notes(self, description: MotorDescription, settings: ArduinoMotorSettings) -> Sequence[str]:
        return (BOARD, TIMEOUT) if settings.model else (BOARD, TIMEOUT, COUNTING)

    def check(self, description: MotorDescription, settings: ArduinoMotorSettings, robot: RobotDescription) -> None:
        if settings.model:
            require_drivable(description, settings.model, settings.control, robot)
            return
        if settings.control:
            raise ValueError("control needs the motor's model, which is missing; add model, or leave control out")
        require_countable(description, counts_per_turn(description.name, settings, robot))

    def open(self, description: MotorDescription, settings: ArduinoMotorSettings, host: Host) -> Motor:
        board = self.open_board_with_wheels(description.name, settings, host)
        _set_duty_mode(board, description.name, is_duty_mode=settings.model is not None)
        board.protocol.limit(settings.board_timeout_s)
        if settings.model:
            output = self.open_output(description, settings, host)
            return open_motor(description, settings.model, settings.control, lambda: output, host)
        counts = counts_per_turn(description.name, settings, host.robot)
        unit = counts / math.tau * board.protocol.firmware.control_period_s
        return CountingMotor(description, self.open_output(description, settings, host, unit), unit)


def _set_duty_mode(board: Board[ArduinoProtocol], motor: str, *, is_duty_mode: bool) -> None:
    if is_duty_mode and not board.protocol.firmware.takes_duties:
        require_robotcore_bridge(board, motor, "takes no duties", "remove model from both motors")
    if board.protocol.is_duty_mode not in (None, is_duty_mode):
        problem = f"one motor on {board.line.place} has a model, and the other has none"
        raise DeviceError(
            motor, f"{problem}. Give both motors a model, or neither", kind="motors-differ", place=board.line.place
        )
    board.protocol.is_duty_mode = is_duty_mode


class ArduinoEncoder(ArduinoDriver, EncoderDriver[ArduinoEncoderSettings]):
    """Opens encoders on an Arduino. One reply of the board has the counts of both encoders."""

    name = ENCODER
    summary = "a wheel's encoder on an Arduino with ROSArduinoBridge or robotcore_bridge, on a serial line"
    settings = ArduinoEncoderSettings

    def notes(self, description: EncoderDescription, settings: ArduinoEncoderSettings) -> Sequence[str]:
        edges = edges_per_turn(description, settings.counts)
        return BOARD, EDGES.format(edges=edges, counts_per_turn=description.counts_per_turn, counts=settings.counts)

    def open(self, description: EncoderDescription, settings: ArduinoEncoderSettings, host: Host) -> Encoder:
        self.open_board_with_wheels(description.name, settings, host).protocol.count_every(COUNT_S)
        return super().open(description, settings, host)

    def rad_per_unit(
        self, description: EncoderDescription, settings: ArduinoEncoderSettings, robot: RobotDescription
    ) -> float:
        return math.tau / edges_per_turn(description, settings.counts)


class ArduinoSonar(ArduinoDriver):
    """Opens ultrasonic modules on an Arduino.

    robotcore_bridge measures periodically. ROSArduinoBridge measures on request, and processes no other request until
    the measurement ends.
    """

    name = "ros-arduino-sonar"
    summary = "an ultrasonic module on an Arduino with ROSArduinoBridge or robotcore_bridge, on a serial line"
    described = RangeSensorDescription
    settings = ArduinoSonarSettings
    aliases: ClassVar[tuple[str, ...]] = ("arduino", "sonar", "ultrasonic", "hc-sr04")

    def connections(self, settings: ArduinoSonarSettings) -> Sequence[Connection]:
        return settings.connections("sonar" if settings.pin is None else f"sonar on pin {settings.pin}")

    def notes(self, description: RangeSensorDescription, settings: ArduinoSonarSettings) -> Sequence[str]:
        return BOARD, UNPINNED if settings.pin is None else PINGING

    def check(
        self, description: RangeSensorDescription, settings: ArduinoSonarSettings, robot: RobotDescription
    ) -> None:
        require_timely(settings.cycles, settings.cycle, robot)

    def open(self, description: RangeSensorDescription, settings: ArduinoSonarSettings, host: Host) -> RangeSensor:
        board = self.open_board(description.name, settings, host)
        sampler = RangeSampler(description, settings.cycles)
        if settings.pin is None:
            instead = f"set the module's pin in the robot's file, such as pin = 4 in [serial.{description.name}]"
            require_robotcore_bridge(board, description.name, "needs the module's pin in each request", instead)
        if board.protocol.firmware.is_robotcore_bridge:
            board.protocol.poll(RANGE, RANGE_S, Ranges(description.name, sampler).take)
        else:
            assert settings.pin
            board.protocol.poll(ping(settings.pin), settings.cycle_s, Pings(description, sampler).take)
        sonar = LineRangeSensor(description, sampler, board.line)
        sonar.await_first(self.first_s + (PING_S * MUTE_PINGS if settings.pin else 0))
        return sonar


class ArduinoBattery(ArduinoDriver, BatteryDriver[ArduinoSettings]):
    """Opens the battery that robotcore_bridge measures with a voltage divider. ROSArduinoBridge cannot measure one."""

    name = "ros-arduino-battery"
    summary = "the battery of an Arduino with robotcore_bridge, on a serial line"
    settings = ArduinoSettings

    def open(self, description: BatteryDescription, settings: ArduinoSettings, host: Host) -> Battery:
        board = self.open_board(description.name, settings, host)
        require_robotcore_bridge(board, description.name, "measures no battery")
        board.protocol.measure_voltage()

        def read_voltage() -> Voltage | None:
            if not board.protocol.has_battery:
                raise DeviceError(description.name, NOT_WIRED, kind="battery-not-wired")
            return board.protocol.voltage

        return BoardBattery(description.name, board.line, read_voltage, self.first_s)
