"""The devices of such a board as a robot's file names them."""

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
from drivers.serial.boards.rosarduino.protocol import BATTERY, OBEYED, PING_S, RANGE, STOP_NOW, ping
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
    agree_on_duties,
    counts_per_turn,
    edges_per_turn,
    require_countable,
    require_ours,
    require_sound,
    require_wheels,
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
from robotcore.hardware.polled import RangeSampler, require_timely

ANSWER_S = 4.0
"""An Arduino is reset when its port is opened, and its boot loader waits up to two seconds for a new sketch."""

FIRST_S = 1.0
"""A board that is known by now has answered anything by then."""

COUNT_S = 0.005
"""Encoders are read no more often: a wheel is controlled every 5 ms at most."""

RANGE_S, BATTERY_S = 0.03, 0.5
"""So often our firmware is asked for what it measures by itself."""

DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
SettingsT = TypeVar("SettingsT", bound=ArduinoSettings)


class ArduinoDriver(SerialDriver[DescriptionT, SettingsT]):
    """What the devices of such a board have in common."""

    aliases: ClassVar[tuple[str, ...]] = ("arduino", "uno", "nano", "robotcore-bridge", "rosarduinobridge")

    def notes(self, description: DescriptionT, settings: SettingsT) -> Sequence[str]:
        return (BOARD,)


class ArduinoMotor(ArduinoDriver[MotorDescription, ArduinoMotorSettings]):
    """A velocity that the board holds by its encoders, in whole counts a frame; or a duty, by the motor's model.

    The board's own time-out is told to our firmware. The true ROSArduinoBridge has 2 s, and none other can be told.
    """

    name = "ros-arduino-motor"
    summary = "a motor on an Arduino with ROSArduinoBridge, or with our firmware, on a serial line"
    described = MotorDescription
    what = "motor"
    settings = ArduinoMotorSettings
    reports_direction = True

    def notes(self, description: MotorDescription, settings: ArduinoMotorSettings) -> Sequence[str]:
        return (BOARD, TIMEOUT) if settings.model else (BOARD, TIMEOUT, COUNTING)

    def check(self, description: MotorDescription, settings: ArduinoMotorSettings, robot: RobotDescription) -> None:
        if settings.model:
            require_drivable(description, settings.model, settings.control, robot)
            return
        if settings.control:
            raise ValueError("control goes by duty, and there is no model; add the motor's model, or leave control out")
        require_countable(description, counts_per_turn(description.name, settings, robot))

    def open(self, description: MotorDescription, settings: ArduinoMotorSettings, host: Host) -> Motor:
        board = _board(description.name, settings, host)
        require_wheels(board, description.name)
        agree_on_duties(board, description.name, goes_by_duty=settings.model is not None)
        board.protocol.limit(settings.board_timeout_s)
        output = BoardOutput(description.name, board.line, board.protocol.command, settings.side)
        if settings.model:
            return open_motor(description, settings.model, settings.control, lambda: output, host)
        counts = counts_per_turn(description.name, settings, host.robot)
        return CountingMotor(description, output, counts / math.tau * board.protocol.firmware.frame_s)

    def cutoffs(
        self, description: MotorDescription, settings: ArduinoMotorSettings, host: Host
    ) -> Sequence[CutoffSpec]:
        return (stop_frame(description.name, settings.port, settings.speed, STOP_NOW, OBEYED, host),)


class ArduinoEncoder(ArduinoDriver[EncoderDescription, ArduinoEncoderSettings]):
    """Asks for the counts whenever the line is free for it; both encoders are told in one answer."""

    name = ENCODER
    summary = "a wheel's encoder on an Arduino with ROSArduinoBridge, or with our firmware, on a serial line"
    described = EncoderDescription
    what = "encoder"
    settings = ArduinoEncoderSettings

    def notes(self, description: EncoderDescription, settings: ArduinoEncoderSettings) -> Sequence[str]:
        edges = edges_per_turn(description, settings.counts)
        return BOARD, EDGES.format(edges=edges, counts_per_turn=description.counts_per_turn, counts=settings.counts)

    def open(self, description: EncoderDescription, settings: ArduinoEncoderSettings, host: Host) -> Encoder:
        board = _board(description.name, settings, host)
        require_wheels(board, description.name)
        board.protocol.count_every(COUNT_S)
        turning = board.protocol.counts[settings.side].turning
        encoder = BoardEncoder(
            description.name, board.line, turning, math.tau / edges_per_turn(description, settings.counts)
        )
        encoder.await_first(FIRST_S)
        return encoder


class ArduinoSonar(ArduinoDriver[RangeSensorDescription, ArduinoSonarSettings]):
    """Asks our firmware for what it measures beside all else; has the true one measure, which stops all else there."""

    name = "ros-arduino-sonar"
    summary = "an ultrasonic module on an Arduino with ROSArduinoBridge, or with our firmware, on a serial line"
    described = RangeSensorDescription
    what = "sonar"
    settings = ArduinoSonarSettings
    aliases: ClassVar[tuple[str, ...]] = ("arduino", "sonar", "ultrasonic", "hc-sr04")

    def connections(self, settings: ArduinoSonarSettings) -> Sequence[Connection]:
        return settings.at("sonar" if settings.pin is None else f"sonar on pin {settings.pin}")

    def notes(self, description: RangeSensorDescription, settings: ArduinoSonarSettings) -> Sequence[str]:
        return BOARD, UNPINNED if settings.pin is None else PINGING

    def check(
        self, description: RangeSensorDescription, settings: ArduinoSonarSettings, robot: RobotDescription
    ) -> None:
        require_timely(settings.cycles, settings.cycle, robot)

    def open(self, description: RangeSensorDescription, settings: ArduinoSonarSettings, host: Host) -> RangeSensor:
        board = _board(description.name, settings, host)
        findings = RangeSampler(description, settings.cycles)
        board.protocol.poll(_asked(board, description, settings, findings))
        sonar = Sonar(description, board.line, findings)
        sonar.await_first(FIRST_S + (PING_S * MUTE_PINGS if settings.pin else 0))
        return sonar


class ArduinoBattery(ArduinoDriver[BatteryDescription, ArduinoSettings]):
    """The voltage that our firmware measures by a divider; the true one measures none."""

    name = "ros-arduino-battery"
    summary = "the battery of an Arduino with our firmware, on a serial line"
    described = BatteryDescription
    what = "battery"
    settings = ArduinoSettings

    def open(self, description: BatteryDescription, settings: ArduinoSettings, host: Host) -> Battery:
        board = _board(description.name, settings, host)
        require_ours(board, description.name, "measures no battery")
        voltages = Voltages(description.name)
        board.protocol.poll(Poll(BATTERY, BATTERY_S, voltages.take))
        battery = BoardBattery(description.name, board.line, voltages.newest)
        battery.await_first(FIRST_S)
        return battery


def _board(device: str, settings: ArduinoSettings, host: Host) -> Board[ArduinoProtocol]:
    """Return the board on the settings' port; raises DeviceError by the device's name."""
    make = partial(ArduinoProtocol, settings.speed)
    board = open_board(device, settings.port, ArduinoProtocol, make, host, ANSWER_S)
    require_sound(board, device)
    return board


def _asked(
    board: Board[ArduinoProtocol],
    description: RangeSensorDescription,
    settings: ArduinoSonarSettings,
    findings: RangeSampler,
) -> Poll:
    """Return how a board is asked for ranges; raises DeviceError where it has to be told a pin."""
    if settings.pin is None:
        instead = (
            f"name that pin in the section of {description.name}, such as [serial.{description.name}] with pin = 4"
        )
        require_ours(board, description.name, "is told the pin of its module with each question", instead)
    if board.protocol.firmware.is_ours:
        return Poll(RANGE, RANGE_S, Ranges(description.name, findings).take)
    assert settings.pin
    return Poll(ping(settings.pin), settings.cycle_s, Pings(description, findings).take)
