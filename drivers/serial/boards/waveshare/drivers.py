"""The devices of a Waveshare UGV board as a robot's file names them."""

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
"""A board that was just switched on looks for a Wi-Fi network for 15 s before it takes the first line."""

FIRMWARE = (
    "The board must run Waveshare's ugv_base_ros, and know which rover it is, once for all: send it "
    '{"T":900,"main":1,"module":0}, where main is 1 for the RaspRover, 2 for the UGV Rover, 3 for the UGV Beast, and '
    "module 1 for an arm, 2 for a camera on a gimbal."
)
WIFI = (
    "The board opens a Wi-Fi of its own, called UGV with the password 12345678 where nobody has changed it, and obeys "
    'whoever is in it, past every stop of this program. Switch it off for good: send it {"T":401,"cmd":0}, and restart '
    "it."
)

DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
SettingsT = TypeVar("SettingsT", bound="WaveshareSettings")


class WaveshareSettings(PortSettings):
    """The port of a board; on the header of a Raspberry Pi /dev/serial0, of a Pi 5 /dev/ttyAMA0, on USB a CP2102."""

    speaks: ClassVar[str] = "Waveshare UGV"
    usual_baud: ClassVar[int] = BAUD


class WaveshareMotorSettings(SideSettings, TimeoutSettings, WaveshareSettings):
    """One of a board's two motors."""


class WaveshareEncoderSettings(SideSettings, WaveshareSettings):
    """One of a board's two odometers."""


class WaveshareDriver(SerialDriver[DescriptionT, SettingsT]):
    """What the devices of such a board have in common."""

    aliases = ("ugv", "rasprover", "beast", "general driver")

    def notes(self, description: DescriptionT, settings: SettingsT) -> Sequence[str]:
        return (FIRMWARE, WIFI)


class WaveshareMotor(WaveshareDriver[MotorDescription, WaveshareMotorSettings]):
    """Tells the board a speed in m/s, by the wheel's radius; the board holds it by its own encoders."""

    name = "waveshare-motor"
    summary = "a motor of a Waveshare UGV board on a serial line, whose velocity the board holds"
    described = MotorDescription
    what = "motor"
    settings = WaveshareMotorSettings

    def check(self, description: MotorDescription, settings: WaveshareMotorSettings, robot: RobotDescription) -> None:
        fastest = description.max_velocity_rad_s * _wheel_radius_m(robot)
        if fastest > FASTEST_M_S:
            raise ValueError(
                f"max_velocity_rad_s of {description.name} is {fastest:.3g} m/s, and the board ignores what is beyond "
                f"{FASTEST_M_S:g}; lower it to {FASTEST_M_S / _wheel_radius_m(robot):.3g} at most"
            )

    def open(self, description: MotorDescription, settings: WaveshareMotorSettings, host: Host) -> Motor:
        board = _board(description.name, settings, host)
        board.protocol.limit(settings.board_timeout_s)
        output = BoardOutput(description.name, board.line, board.protocol.command, settings.side)
        return BoardMotor(description, output, _wheel_radius_m(host.robot))

    def cutoffs(
        self, description: MotorDescription, settings: WaveshareMotorSettings, host: Host
    ) -> Sequence[CutoffSpec]:
        return (stop_frame(description.name, settings.port, settings.speed, STOP, STANDING, host),)


class WaveshareEncoder(WaveshareDriver[EncoderDescription, WaveshareEncoderSettings]):
    """Tells the board's odometer as an angle, by the wheel's radius; between its centimetres by the speed."""

    name = "waveshare-encoder"
    summary = "a wheel's encoder on a Waveshare UGV board on a serial line"
    described = EncoderDescription
    what = "encoder"
    settings = WaveshareEncoderSettings

    def check(
        self, description: EncoderDescription, settings: WaveshareEncoderSettings, robot: RobotDescription
    ) -> None:
        _wheel_radius_m(robot)

    def open(self, description: EncoderDescription, settings: WaveshareEncoderSettings, host: Host) -> Encoder:
        board = _board(description.name, settings, host)
        return BoardEncoder(
            description.name,
            board.line,
            board.protocol.odometers[settings.side].turning,
            1 / _wheel_radius_m(host.robot),
        )


class WaveshareBattery(WaveshareDriver[BatteryDescription, WaveshareSettings]):
    """Tells the battery's voltage as the board measures it, every 10 s."""

    name = "waveshare-battery"
    summary = "the battery behind a Waveshare UGV board on a serial line"
    described = BatteryDescription
    what = "battery"
    settings = WaveshareSettings

    def open(self, description: BatteryDescription, settings: WaveshareSettings, host: Host) -> Battery:
        board = _board(description.name, settings, host)
        return BoardBattery(description.name, board.line, lambda: board.protocol.voltage)


def _board(device: str, settings: WaveshareSettings, host: Host) -> Board[WaveshareProtocol]:
    """Return the board on the settings' port; raises DeviceError by the device's name."""
    return open_board(
        device, settings.port, WaveshareProtocol, lambda: WaveshareProtocol(settings.speed), host, ANSWER_S
    )


def _wheel_radius_m(robot: RobotDescription) -> float:
    """Return the radius by which the board's metres are radians; raises ValueError where the robot has no drive."""
    if robot.drive is None:
        raise ValueError("the board goes by m/s, and the robot has no wheel radius; describe its [drive]")
    return robot.drive.wheel_radius_m
