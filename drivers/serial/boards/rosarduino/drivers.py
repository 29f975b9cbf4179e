"""The drivers of an Arduino's devices."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import ClassVar, TypeVar

from drivers.serial.boards.board import Board, open_board
from drivers.serial.boards.cutoff import stop_frame
from drivers.serial.boards.devices import BoardBattery, BoardEncoder, BoardOutput
from drivers.serial.boards.rosarduino.board import ArduinoProtocol
from drivers.serial.boards.rosarduino.devices import MUTE_PINGS, CountingMotor, Pings, Ranges, Sonar, Voltages
from drivers.serial.boards.rosarduino.protocol import BATTERY, PING_S, RANGE, STOP_CONFIRMED, STOP_NOW, ping
from drivers.serial.boards.rosarduino.requests import Poll
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
    require_known_version,
    require_robotcore_bridge,
    require_wheels,
    set_duty_mode,
)
from drivers.serial.driver import SerialDriver
from robotcore.description import (
    BatteryDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    RobotDescription,
    StrictModel,
)
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Battery, Encoder, Motor, RangeSensor
from robotcore.hardware import Connection, Host
from robotcore.hardware.motor_control import open_motor, require_drivable
from robotcore.hardware.polled_samples import RangeSampler, require_timely

ANSWER_S = 4.0
"""The longest wait for the board's first reply, in seconds. Opening the port resets an Arduino. Its boot loader then
waits up to two seconds for a new sketch."""

FIRST_S = 1.0
"""The longest wait for the first sample of a device after the first reply of its board, in seconds."""

COUNT_S = 0.005
"""The period of requesting encoder counts, in seconds; equal to the shortest period of velocity control."""

RANGE_S, BATTERY_S = 0.03, 0.5
"""The periods of requesting the range and the battery's voltage from robotcore_bridge, in seconds."""

DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
SettingsT = TypeVar("SettingsT", bound=ArduinoSettings)


class ArduinoDriver(SerialDriver[DescriptionT, SettingsT]):
    """The base class of the drivers of an Arduino's devices."""

    aliases: ClassVar[tuple[str, ...]] = ("arduino", "uno", "nano", "robotcore-bridge", "rosarduinobridge")

    def notes(self, description: DescriptionT, settings: SettingsT) -> Sequence[str]:
        return (BOARD,)


class ArduinoMotor(ArduinoDriver[MotorDescription, ArduinoMotorSettings]):
    """Opens motors on an Arduino. A motor with a model gets duties; without a model, the board controls its velocity.

    The driver sets the time-out of robotcore_bridge. The time-out of ROSArduinoBridge is always 2 s.
    """

    name = "ros-arduino-motor"
    summary = "a motor on an Arduino with ROSArduinoBridge or robotcore_bridge, on a serial line"
    described = MotorDescription
    part = "motor"
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
        board = _open_supported_board(description.name, settings, host)
        require_wheels(board, description.name)
        set_duty_mode(board, description.name, is_duty_mode=settings.model is not None)
        board.protocol.limit(settings.board_timeout_s)
        output = BoardOutput(description.name, board.line, board.protocol.command, settings.side)
        if settings.model:
            return open_motor(description, settings.model, settings.control, lambda: output, host)
        counts = counts_per_turn(description.name, settings, host.robot)
        return CountingMotor(description, output, counts / math.tau * board.protocol.firmware.control_period_s)

    def cutoffs(
        self, description: MotorDescription, settings: ArduinoMotorSettings, host: Host
    ) -> Sequence[CutoffSpec]:
        return (stop_frame(description.name, settings.port, settings.speed, STOP_NOW, STOP_CONFIRMED, host),)


class ArduinoEncoder(ArduinoDriver[EncoderDescription, ArduinoEncoderSettings]):
    """Opens encoders on an Arduino. One reply of the board has the counts of both encoders."""

    name = ENCODER
    summary = "a wheel's encoder on an Arduino with ROSArduinoBridge or robotcore_bridge, on a serial line"
    described = EncoderDescription
    part = "encoder"
    settings = ArduinoEncoderSettings

    def notes(self, description: EncoderDescription, settings: ArduinoEncoderSettings) -> Sequence[str]:
        edges = edges_per_turn(description, settings.counts)
        return BOARD, EDGES.format(edges=edges, counts_per_turn=description.counts_per_turn, counts=settings.counts)

    def open(self, description: EncoderDescription, settings: ArduinoEncoderSettings, host: Host) -> Encoder:
        board = _open_supported_board(description.name, settings, host)
        require_wheels(board, description.name)
        board.protocol.count_every(COUNT_S)
        counter = board.protocol.counts[settings.side].counter
        encoder = BoardEncoder(
            description.name, board.line, counter, math.tau / edges_per_turn(description, settings.counts)
        )
        encoder.await_first(FIRST_S)
        return encoder


class ArduinoSonar(ArduinoDriver[RangeSensorDescription, ArduinoSonarSettings]):
    """Opens ultrasonic modules on an Arduino.

    robotcore_bridge measures periodically. ROSArduinoBridge measures on request, and processes no other request until
    the measurement ends.
    """

    name = "ros-arduino-sonar"
    summary = "an ultrasonic module on an Arduino with ROSArduinoBridge or robotcore_bridge, on a serial line"
    described = RangeSensorDescription
    part = "sonar"
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
        board = _open_supported_board(description.name, settings, host)
        sampler = RangeSampler(description, settings.cycles)
        board.protocol.poll(_sonar_poll(board, description, settings, sampler))
        sonar = Sonar(description, board.line, sampler)
        sonar.await_first(FIRST_S + (PING_S * MUTE_PINGS if settings.pin else 0))
        return sonar


class ArduinoBattery(ArduinoDriver[BatteryDescription, ArduinoSettings]):
    """Opens the battery that robotcore_bridge measures with a voltage divider. ROSArduinoBridge cannot measure one."""

    name = "ros-arduino-battery"
    summary = "the battery of an Arduino with robotcore_bridge, on a serial line"
    described = BatteryDescription
    part = "battery"
    settings = ArduinoSettings

    def open(self, description: BatteryDescription, settings: ArduinoSettings, host: Host) -> Battery:
        board = _open_supported_board(description.name, settings, host)
        require_robotcore_bridge(board, description.name, "measures no battery")
        voltages = Voltages(description.name)
        board.protocol.poll(Poll(BATTERY, BATTERY_S, voltages.take))
        battery = BoardBattery(description.name, board.line, voltages.newest)
        battery.await_first(FIRST_S)
        return battery


def _open_supported_board(device: str, settings: ArduinoSettings, host: Host) -> Board[ArduinoProtocol]:
    make = partial(ArduinoProtocol, settings.speed)
    board = open_board(device, settings.port, ArduinoProtocol, make, host, ANSWER_S)
    require_known_version(board, device)
    return board


def _sonar_poll(
    board: Board[ArduinoProtocol],
    description: RangeSensorDescription,
    settings: ArduinoSonarSettings,
    sampler: RangeSampler,
) -> Poll:
    if settings.pin is None:
        instead = f"set the module's pin in the robot's file, such as pin = 4 in [serial.{description.name}]"
        require_robotcore_bridge(board, description.name, "needs the module's pin in each request", instead)
    if board.protocol.firmware.is_robotcore_bridge:
        return Poll(RANGE, RANGE_S, Ranges(description.name, sampler).take)
    assert settings.pin
    return Poll(ping(settings.pin), settings.cycle_s, Pings(description, sampler).take)
