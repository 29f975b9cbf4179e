"""Whether a board can do what a robot's file wants of it: told before any wheel turns."""

from __future__ import annotations

import math

from drivers.serial.boards.board import Board
from drivers.serial.boards.rosarduino.board import ArduinoTalk
from drivers.serial.boards.rosarduino.protocol import FASTEST
from drivers.serial.boards.rosarduino.settings import ArduinoMotorSettings, edges_per_turn
from robotcore.description import EncoderDescription, MotorDescription, RobotDescription
from robotcore.errors import DeviceError
from robotcore.hardware import encoder_of

ENCODER = "ros-arduino-encoder"
"""The driver of the encoders by which a board holds velocities."""

FRAMES_A_SECOND = 30

FLASH_OURS = "flash ours: robotcore firmware flash"


def counts_per_turn(motor: str, settings: ArduinoMotorSettings, robot: RobotDescription) -> int:
    """Return how far the board counts on a turn of a motor's wheel, by the section of the encoder on it.

    Raises ValueError where the robot's file does not say.
    """
    name, elsewhere = encoder_of(motor, robot), ""
    for told in robot.all_of(EncoderDescription):
        for section in robot.backends.values():
            found = section.get(name) if told.name == name else None
            table = found if isinstance(found, dict) else {}  # that it is no table is told where it is read
            if table.get("driver") == ENCODER and table.get("port") == settings.port:
                return edges_per_turn(told, table.get("counts"))
            elsewhere = table.get("port", elsewhere) if table.get("driver") == ENCODER else elsewhere
    if elsewhere:
        raise ValueError(
            f"{motor} is on {settings.port}, and {name}, by which the board holds its velocity, on {elsewhere}; write "
            "the same port at both"
        )
    raise ValueError(
        f"the board holds the velocity of {motor} by its wheel's encoder, and none of {settings.port} is told of; name "
        f"the encoders in [drive] and connect them by {ENCODER}, or add the motor's model"
    )


def require_countable(told: MotorDescription, counts: int) -> None:
    """Raise ValueError where at its fastest a wheel makes less than a count a frame, or more than the board takes."""
    fastest = told.max_velocity_rad_s * counts / math.tau / FRAMES_A_SECOND
    if fastest < 1:
        raise ValueError(
            f"max_velocity_rad_s of {told.name} is {fastest:.2g} counts in the board's frame of 1/30 s, and it takes "
            "whole ones; take encoders with more counts, or add the motor's model"
        )
    if fastest > FASTEST:
        raise ValueError(
            f"max_velocity_rad_s of {told.name} is {fastest:.0f} counts in the board's frame of 1/30 s, and it takes "
            f"{FASTEST}; lower it to {math.floor(told.max_velocity_rad_s * FASTEST / fastest)}"
        )


def require_sound(board: Board[ArduinoTalk], device: str) -> None:
    """Raise DeviceError where the board speaks what is not known."""
    if fault := board.talk.firmware.fault:
        raise DeviceError(device, f"the board on {board.line.place} cannot be worked with: {fault}")


def require_wheels(board: Board[ArduinoTalk], device: str) -> None:
    """Raise DeviceError where the board has no motors and no encoders."""
    if not board.talk.firmware.has_wheels:
        fault = f"the ROSArduinoBridge on {board.line.place} was built without wheels"
        raise DeviceError(device, f"{fault}. Define USE_BASE and flash it again, or {FLASH_OURS}")


def require_ours(board: Board[ArduinoTalk], device: str, lacks: str, instead: str = "") -> None:
    """Raise DeviceError, by what the true one lacks and what else to do, where the board does not run our firmware."""
    if not board.talk.firmware.is_ours:
        fault = f"{board.line.place} has the true ROSArduinoBridge, which {lacks}"
        remedy = f"{instead}, or {FLASH_OURS}" if instead else FLASH_OURS
        raise DeviceError(device, f"{fault}. {remedy[0].upper()}{remedy[1:]}")


def agree_on_duties(board: Board[ArduinoTalk], motor: str, *, goes_by_duty: bool) -> None:
    """Have the board's motors told duties, or counts; raises DeviceError where it cannot, or the other one differs."""
    if goes_by_duty and not board.talk.firmware.takes_duties:
        require_ours(board, motor, "takes no duties", "leave model out of both motors")
    if board.talk.goes_by_duty not in (None, goes_by_duty):
        fault = f"one motor on {board.line.place} has a model, and one has none"
        raise DeviceError(motor, f"{fault}. Give both one, or none")
    board.talk.goes_by_duty = goes_by_duty
