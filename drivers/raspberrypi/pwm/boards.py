"""The channels of motors and servos on known boards with a PCA9685."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from robotcore.errors import Mistake

TWO_INPUTS, TWO_INPUTS_AND_PWM = ("forward", "backward"), ("forward", "backward", "pwm")
"""The keys of the channels of a motor whose bridge has two inputs, and of one that has an input for the PWM too."""


@dataclass(frozen=True)
class Board:
    """A board with motors, which plugs onto the header."""

    title: str
    address: int
    frequency_hz: int
    signals: tuple[str, ...]
    """The keys of a motor's channels."""
    motors: Mapping[str, tuple[int, ...]]
    """The channels of each motor, by its place on the board."""
    servos: range = range(0)
    """The channels of the connectors for servos."""

    @property
    def note(self) -> str:
        """The note that `robotcore wiring` prints for a device on the board."""
        return (
            f"The {self.title} plugs onto the header, so the Pi needs no further wires to it. Connect the battery of "
            "the motors to the board."
        )


BOARDS = {
    # Source: https://github.com/adafruit/Adafruit_CircuitPython_MotorKit/blob/main/adafruit_motorkit.py
    "adafruit-motor-hat": Board(
        "Adafruit DC and Stepper Motor HAT or Bonnet",
        0x60,
        1500,
        TWO_INPUTS_AND_PWM,
        {"M1": (9, 10, 8), "M2": (11, 12, 13), "M3": (3, 4, 2), "M4": (5, 6, 7)},
    ),
    # Source: https://www.waveshare.net/w/upload/9/9a/Motor_Driver_HAT_Code.7z, main.py. Its jumpers set the address.
    "waveshare-motor-driver-hat": Board(
        "Waveshare Motor Driver HAT", 0x40, 1500, TWO_INPUTS_AND_PWM, {"MA": (2, 1, 0), "MB": (4, 3, 5)}
    ),
    # Source: https://github.com/Freenove/Freenove_4WD_Smart_Car_Kit_for_Raspberry_Pi, Code/Server/Motor.py and
    # servo.py.
    "freenove-4wd": Board(
        "board of the Freenove 4WD Smart Car",
        0x40,
        50,
        TWO_INPUTS,
        {"front-left": (0, 1), "rear-left": (3, 2), "front-right": (6, 7), "rear-right": (4, 5)},
        range(8, 16),
    ),
}
"""The boards by their names in a robot's file."""


def build_servo_settings(board: Any, channel: Any) -> dict[str, int]:
    """Return the settings of a servo on a board. Raises Mistake for an unknown board, or a board without this servo."""
    known = _find_board(board)
    if channel not in known.servos:
        problem = f"channel is {channel!r}, and not one of a servo on the {known.title}"
        remedy = f"Use {known.servos[0]} to {known.servos[-1]}" if known.servos else "Remove board"
        raise Mistake(problem, remedy, kind="unknown-servo")
    return {"address": known.address}


def build_motor_settings(board: Any, motor: Any) -> dict[str, int]:
    """Return the settings of a motor on a board; raises Mistake for an unknown board or motor."""
    known = _find_board(board)
    if not isinstance(motor, str) or motor not in known.motors:
        problem = f"motor is {motor!r}, and not a motor of the {known.title}"
        raise Mistake(problem, f"Use {_list(known.motors)}", kind="unknown-motor")
    channels = dict(zip(known.signals, known.motors[motor], strict=True))
    return {"address": known.address, "frequency_hz": known.frequency_hz, **channels}


def _find_board(board: Any) -> Board:
    if not isinstance(board, str) or board not in BOARDS:
        raise Mistake(f"board is {board!r}, and not the name of a board", f"Use {_list(BOARDS)}", kind="unknown-board")
    return BOARDS[board]


def _list(names: Mapping[str, Any]) -> str:
    *first, last = map(repr, names)
    return f"{', '.join(first)} or {last}"
