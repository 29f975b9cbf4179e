"""The settings and drivers of the devices on a Waveshare UGV board."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, TypeVar

from drivers.serial.boards.board import Board, open_board
from drivers.serial.boards.cutoff import stop_frame
from drivers.serial.boards.devices import BoardBattery, BoardEncoder, BoardMotor, BoardOutput
from drivers.serial.boards.waveshare.board import WaveshareProtocol
from drivers.serial.boards.waveshare.protocol import BAUD, FASTEST_M_S, STANDING, STOP
from drivers.serial.driver import PortSettings, SerialDriver, SideSettings, TimeoutSettings
from robotcore.description import (
    BatteryDescription,
    EncoderDescription,
    MotorDescription,
    RobotDescription,
    StrictModel,
)
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Battery, Encoder, Motor
from robotcore.hardware import Host

ANSWER_S = 20.0
"""The longest wait for the board's first feedback, in seconds. After power-on the board searches for a Wi-Fi network
for 15 s, and sends nothing."""

FIRMWARE = (
    "The board must run Waveshare's ugv_base_ros. Set the rover once: send "
    '{"T":900,"main":1,"module":0} to the board. main is 1 for the RaspRover, 2 for the UGV Rover and 3 for the UGV '
    "Beast; module is 1 for an arm and 2 for a camera on a gimbal."
)
WIFI = (
    "The board opens its own Wi-Fi, by default UGV with the password 12345678. It obeys every computer in it, even "
    "while this program stops the motors. Switch the Wi-Fi off for good: send "
    '{"T":401,"cmd":0} to the board, and restart it.'
)

DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
SettingsT = TypeVar("SettingsT", bound="WaveshareSettings")


class WaveshareSettings(PortSettings):
    """The settings of a device on a Waveshare board.

    On the header of a Raspberry Pi, the port is /dev/serial0 (Pi 5: /dev/ttyAMA0). On USB, the board has a CP2102.
    """

    protocol_name: ClassVar[str] = "Waveshare UGV"
    default_baud: ClassVar[int] = BAUD


class WaveshareMotorSettings(SideSettings, TimeoutSettings, WaveshareSettings):
    """The settings of a motor on a Waveshare board."""


class WaveshareEncoderSettings(SideSettings, WaveshareSettings):
    """The settings of an encoder on a Waveshare board."""


class WaveshareDriver(SerialDriver[DescriptionT, SettingsT]):
    """The base class of the drivers of a Waveshare board's devices."""

    aliases = ("ugv", "rasprover", "beast", "general driver")

    def notes(self, description: DescriptionT, settings: SettingsT) -> Sequence[str]:
        return (FIRMWARE, WIFI)


class WaveshareMotor(WaveshareDriver[MotorDescription, WaveshareMotorSettings]):
    """Opens motors. The board controls their velocities by its own encoders."""

    name = "waveshare-motor"
    summary = "a motor of a Waveshare UGV board on a serial line; the board controls its velocity"
    described = MotorDescription
    part = "motor"
    settings = WaveshareMotorSettings

    def check(self, description: MotorDescription, settings: WaveshareMotorSettings, robot: RobotDescription) -> None:
        fastest = description.max_velocity_rad_s * _wheel_radius_m(robot)
        if fastest > FASTEST_M_S:
            raise ValueError(
                f"max_velocity_rad_s of {description.name} is {fastest:.3g} m/s, but the board ignores commands above "
                f"{FASTEST_M_S:g} m/s; lower it to {FASTEST_M_S / _wheel_radius_m(robot):.3g} at most"
            )

    def open(self, description: MotorDescription, settings: WaveshareMotorSettings, host: Host) -> Motor:
        board = _open_board(description.name, settings, host)
        board.protocol.limit(settings.board_timeout_s)
        output = BoardOutput(description.name, board.line, board.protocol.command, settings.side)
        return BoardMotor(description, output, _wheel_radius_m(host.robot))

    def cutoffs(
        self, description: MotorDescription, settings: WaveshareMotorSettings, host: Host
    ) -> Sequence[CutoffSpec]:
        return (stop_frame(description.name, settings.port, settings.speed, STOP, STANDING, host),)


class WaveshareEncoder(WaveshareDriver[EncoderDescription, WaveshareEncoderSettings]):
    """Opens encoders, whose angle is the distance of an `Odometer` divided by the wheel's radius."""

    name = "waveshare-encoder"
    summary = "a wheel's encoder on a Waveshare UGV board on a serial line"
    described = EncoderDescription
    part = "encoder"
    settings = WaveshareEncoderSettings

    def check(
        self, description: EncoderDescription, settings: WaveshareEncoderSettings, robot: RobotDescription
    ) -> None:
        _wheel_radius_m(robot)

    def open(self, description: EncoderDescription, settings: WaveshareEncoderSettings, host: Host) -> Encoder:
        board = _open_board(description.name, settings, host)
        return BoardEncoder(
            description.name,
            board.line,
            board.protocol.odometers[settings.side].counter,
            1 / _wheel_radius_m(host.robot),
        )


class WaveshareBattery(WaveshareDriver[BatteryDescription, WaveshareSettings]):
    """Opens the battery, whose voltage the board measures every 10 s."""

    name = "waveshare-battery"
    summary = "the battery of a Waveshare UGV board on a serial line"
    described = BatteryDescription
    part = "battery"
    settings = WaveshareSettings

    def open(self, description: BatteryDescription, settings: WaveshareSettings, host: Host) -> Battery:
        board = _open_board(description.name, settings, host)
        return BoardBattery(description.name, board.line, lambda: board.protocol.voltage)


def _open_board(device: str, settings: WaveshareSettings, host: Host) -> Board[WaveshareProtocol]:
    return open_board(
        device, settings.port, WaveshareProtocol, lambda: WaveshareProtocol(settings.speed), host, ANSWER_S
    )


def _wheel_radius_m(robot: RobotDescription) -> float:
    if robot.drive is None:
        raise ValueError("the board takes m/s, but the robot has no wheel radius; add [drive] to the robot's file")
    return robot.drive.wheel_radius_m
