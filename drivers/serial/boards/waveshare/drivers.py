"""The drivers of the devices on a Waveshare UGV board."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from drivers.serial.boards.drivers import BatteryDriver, BoardDriver, BoardTimeout, EncoderDriver, MotorDriver
from drivers.serial.boards.waveshare.protocol import BAUD, MAX_SPEED_M_S, STANDING, STOP, WaveshareProtocol
from robotcore.description import RobotDescription
from robotcore.hardware import DeviceContext, Drivers
from robotcore.hardware.motor_model import OutputMotor
from robotcore.kinds.encoder import EncoderDescription
from robotcore.kinds.motor import Motor, MotorDescription

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


class WaveshareDriver(BoardDriver):
    """The base class of the drivers of a Waveshare board's devices.

    On the header of a Raspberry Pi, the port is /dev/serial0 (Pi 5: /dev/ttyAMA0). On USB, the board has a CP2102.
    """

    aliases = ("ugv", "rasprover", "beast", "general driver")
    protocol_name = "Waveshare UGV"
    default_baud = BAUD
    protocol = WaveshareProtocol
    answer_s = 20.0  # after power-on the board searches for a Wi-Fi network for 15 s, and sends nothing
    stop, standing = STOP, STANDING

    def notes(self, description: Any) -> Sequence[str]:
        return (FIRMWARE, WIFI)


class WaveshareMotor(WaveshareDriver, MotorDriver):
    """Opens motors. The board controls their velocities by its own encoders."""

    name = "waveshare-motor"
    summary = "a motor of a Waveshare UGV board on a serial line; the board controls its velocity"

    board_timeout_s: BoardTimeout = 0.5

    def check(self, description: MotorDescription, robot: RobotDescription, drivers: Drivers) -> None:
        fastest = self.trim * description.max_velocity_rad_s * _wheel_radius_m(robot)
        if fastest > MAX_SPEED_M_S:
            raise ValueError(
                f"max_velocity_rad_s of {description.name} is {fastest:.3g} m/s, but the board ignores commands above "
                f"{MAX_SPEED_M_S:g} m/s; lower it to {MAX_SPEED_M_S / self.trim / _wheel_radius_m(robot):.3g} at most"
            )

    def open(self, description: MotorDescription, context: DeviceContext) -> Motor:
        self.open_board(description.name, context).protocol.limit(self.board_timeout_s)
        return OutputMotor(description, self.open_output(description.name, context, _wheel_radius_m(context.robot)))


class WaveshareEncoder(WaveshareDriver, EncoderDriver):
    """Opens encoders, whose angle is the distance of an `Odometer` divided by the wheel's radius."""

    name = "waveshare-encoder"
    summary = "a wheel's encoder on a Waveshare UGV board on a serial line"

    def check(self, description: EncoderDescription, robot: RobotDescription, drivers: Drivers) -> None:
        _wheel_radius_m(robot)

    def rad_per_unit(self, description: EncoderDescription, robot: RobotDescription) -> float:
        return 1 / _wheel_radius_m(robot)


class WaveshareBattery(WaveshareDriver, BatteryDriver):
    """Opens the battery, whose voltage the board measures every 10 s."""

    name = "waveshare-battery"
    summary = "the battery of a Waveshare UGV board on a serial line"


def _wheel_radius_m(robot: RobotDescription) -> float:
    if robot.drive is None:
        raise ValueError("the board takes m/s, but the robot has no wheel radius; add [drive] to the robot's file")
    return robot.drive.wheel_radius_m
