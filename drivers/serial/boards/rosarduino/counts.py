"""The counts of an Arduino's encoders in a turn of a wheel, and in a period of its velocity control."""

from __future__ import annotations

import math

from drivers.serial.boards.rosarduino.protocol import FASTEST
from robotcore.description import EncoderDescription, MotorDescription, RobotDescription
from robotcore.hardware import encoder_of


def edges_per_turn(description: EncoderDescription, counts: object) -> int:
    """Return the edges in a turn of the wheel. The board counts all edges, four in each cycle.

    counts: the setting ``counts`` of the encoder, "cycles" or "edges".
    """
    return description.counts_per_turn * (1 if counts == "edges" else 4)


ENCODER = "ros-arduino-encoder"
"""The name of the driver of encoders on an Arduino."""

CONTROL_RATE_HZ = 30
"""The rate of the board's velocity control. It takes counts in a period of it."""


def counts_per_turn(motor: str, port: str, robot: RobotDescription) -> int:
    """Return the board's counts in a turn of a motor's wheel, from the settings of the wheel's encoder.

    port: the port of the motor's board.

    Raises ValueError if the robot's file has no encoder of this wheel on the motor's port.
    """
    name, elsewhere = encoder_of(motor, robot), ""
    for description in robot.all_of(EncoderDescription):
        for section in robot.backends.values():
            found = section.get(name) if description.name == name else None
            table = found if isinstance(found, dict) else {}  # the check of the encoder reports another type
            if table.get("driver") == ENCODER and table.get("port") == port:
                return edges_per_turn(description, table.get("counts"))
            elsewhere = table.get("port", elsewhere) if table.get("driver") == ENCODER else elsewhere
    if elsewhere:
        raise ValueError(
            f"the board of {motor} is on {port} and needs the encoder {name}, which is on {elsewhere}; write "
            "the same port for both"
        )
    raise ValueError(
        f"the board controls the velocity of {motor} by its wheel's encoder, but no encoder is on {port}; "
        f"name the encoders in [drive] and connect them with {ENCODER}, or add the motor's model"
    )


def require_countable(description: MotorDescription, counts: int) -> None:
    """Raise ValueError if the motor's maximum velocity is below one count per control period, or above `FASTEST`.

    counts: the board's counts in a turn of the wheel.
    """
    fastest = description.max_velocity_rad_s * counts / math.tau / CONTROL_RATE_HZ
    if fastest < 1:
        raise ValueError(
            f"max_velocity_rad_s of {description.name} is {fastest:.2g} counts per control period of 1/30 s, but the "
            "board takes whole counts; use encoders with more counts, or add the motor's model"
        )
    if fastest > FASTEST:
        raise ValueError(
            f"max_velocity_rad_s of {description.name} is {fastest:.0f} counts per control period of 1/30 s, but "
            f"the board takes {FASTEST} at most; "
            f"lower it to {math.floor(description.max_velocity_rad_s * FASTEST / fastest)}"
        )
