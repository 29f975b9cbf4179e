"""Settings of the devices on such a board, the notes for wiring them, and checks of both."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from drivers.serial.boards.board import Board
from drivers.serial.boards.rosarduino.board import ArduinoProtocol
from drivers.serial.boards.rosarduino.protocol import FASTEST
from drivers.serial.driver import PortSettings, SideSettings, TimeoutSettings
from robotcore.description import EncoderDescription, MotorDescription, RobotDescription
from robotcore.errors import DeviceError
from robotcore.hardware import encoder_of
from robotcore.hardware.motor_control import Control
from robotcore.hardware.motor_model import Model

OUR_CYCLE_S = 0.06
"""How often our firmware triggers its ultrasonic module."""

ECHO_FREE_S = 0.6

BOARD = (
    "The board runs ROSArduinoBridge, or the firmware that robotcore firmware flash puts on it, which stops sooner, "
    "sums its lines, and measures range and battery beside all else. Which of its pins a wire goes to is in the "
    "firmware's config.h, and in docs/firmware.md."
)
TIMEOUT = (
    "The true ROSArduinoBridge stops the motors 2 s after the last command, whatever board_timeout_s says; "
    "our firmware takes board_timeout_s."
)
COUNTING = (
    "The board takes whole counts in 1/30 s: set_velocity returns the velocity that they are, and what is less than "
    "half a count stands."
)
EDGES = (
    "A turn of the wheel is {edges} edges of the encoder's two channels, as counts_per_turn = {counts_per_turn} and "
    'counts = "{counts}" have it. A wheel that has a quarter of them turns four times as fast as it is told: count '
    "them once, as docs/firmware.md says."
)
UNPINNED = (
    "Our firmware measures by pins of its own. The true ROSArduinoBridge has to be told the module's: add such as "
    "pin = 4."
)
PINGING = (
    "The true ROSArduinoBridge does nothing else while it listens for an echo, 38 ms where none comes and 1 s where no "
    "module is at that pin: it holds no velocity and takes no stop until then."
)


class ArduinoSettings(PortSettings):
    """The port of a board."""

    speaks: ClassVar[str] = "ROSArduinoBridge"
    usual_baud: ClassVar[int] = 57600


class ArduinoEncoderSettings(SideSettings, ArduinoSettings):
    """Which of the board's two encoders it is, and what a count is.

    ``counts`` says what the description's ``counts_per_turn`` counts, on a turn of the wheel, gear included: "cycles"
    of one channel (a data sheet's PPR, a disc's slots), of which the board counts all four edges, or those "edges"
    themselves (often called CPR).
    """

    counts: Literal["cycles", "edges"] = "cycles"


class ArduinoMotorSettings(SideSettings, TimeoutSettings, ArduinoSettings):
    """Which of the board's two motors it is, and who holds its velocity.

    Without a ``model`` the board does, by its wheel's encoder on the same board. With one the board is told duties;
    with ``control`` too, the velocity is held from here.
    """

    model: Model | None = None
    control: Control | None = None


class ArduinoSonarSettings(ArduinoSettings):
    """How it is judged, and, where the board runs the true ROSArduinoBridge, its pin and how often it is asked.

    So many ``echo_free_cycles`` in a row vouch for nothing in range, by default those of 0.6 s; 0: only an echo from
    beyond does. Our firmware has pins of its own, and cycles of 0.06 s.
    """

    pin: Annotated[int, Field(ge=2, le=69)] | None = None
    cycle_s: Annotated[float, Field(ge=0.05, le=1)] = 0.1
    echo_free_cycles: Annotated[int, Field(ge=0, le=100)] | None = None

    @property
    def cycle(self) -> float:
        """How long a cycle is, in seconds."""
        return OUR_CYCLE_S if self.pin is None else self.cycle_s

    @property
    def cycles(self) -> int:
        """How many cycles in a row without an echo vouch for nothing in range."""
        return max(1, round(ECHO_FREE_S / self.cycle)) if self.echo_free_cycles is None else self.echo_free_cycles


def edges_per_turn(description: EncoderDescription, counts: object) -> int:
    """Return how far a board counts on a turn of the wheel: all four edges of each cycle."""
    return description.counts_per_turn * (1 if counts == "edges" else 4)


ENCODER = "ros-arduino-encoder"
"""The driver of the encoders by which a board holds velocities."""

FRAMES_A_SECOND = 30

FLASH_OURS = "flash ours: robotcore firmware flash"


def counts_per_turn(motor: str, settings: ArduinoMotorSettings, robot: RobotDescription) -> int:
    """Return how far the board counts on a turn of a motor's wheel, by the section of the encoder on it.

    Raises ValueError where the robot's file does not say.
    """
    name, elsewhere = encoder_of(motor, robot), ""
    for description in robot.all_of(EncoderDescription):
        for section in robot.backends.values():
            found = section.get(name) if description.name == name else None
            table = found if isinstance(found, dict) else {}  # that it is no table is told where it is read
            if table.get("driver") == ENCODER and table.get("port") == settings.port:
                return edges_per_turn(description, table.get("counts"))
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


def require_countable(description: MotorDescription, counts: int) -> None:
    """Raise ValueError where at its fastest a wheel makes less than a count a frame, or more than the board takes."""
    fastest = description.max_velocity_rad_s * counts / math.tau / FRAMES_A_SECOND
    if fastest < 1:
        raise ValueError(
            f"max_velocity_rad_s of {description.name} is {fastest:.2g} counts in the board's frame of 1/30 s, and it "
            "takes whole ones; take encoders with more counts, or add the motor's model"
        )
    if fastest > FASTEST:
        raise ValueError(
            f"max_velocity_rad_s of {description.name} is {fastest:.0f} counts in the board's frame of 1/30 s, and it "
            f"takes {FASTEST}; lower it to {math.floor(description.max_velocity_rad_s * FASTEST / fastest)}"
        )


def require_sound(board: Board[ArduinoProtocol], device: str) -> None:
    """Raise DeviceError where the board speaks what is not known."""
    if fault := board.protocol.firmware.fault:
        raise DeviceError(
            device,
            f"the board on {board.line.place} cannot be worked with: {fault}",
            kind="firmware-version",
            place=board.line.place,
        )


def require_wheels(board: Board[ArduinoProtocol], device: str) -> None:
    """Raise DeviceError where the board has no motors and no encoders."""
    if not board.protocol.firmware.has_wheels:
        fault = f"the ROSArduinoBridge on {board.line.place} was built without wheels"
        raise DeviceError(
            device,
            f"{fault}. Define USE_BASE and flash it again, or {FLASH_OURS}",
            kind="board-without-wheels",
            place=board.line.place,
        )


def require_ours(board: Board[ArduinoProtocol], device: str, lacks: str, instead: str = "") -> None:
    """Raise DeviceError, by what the true one lacks and what else to do, where the board does not run our firmware."""
    if not board.protocol.firmware.is_ours:
        fault = f"{board.line.place} has the true ROSArduinoBridge, which {lacks}"
        remedy = f"{instead}, or {FLASH_OURS}" if instead else FLASH_OURS
        raise DeviceError(
            device,
            f"{fault}. {remedy[0].upper()}{remedy[1:]}",
            kind="firmware-lacks",
            place=board.line.place,
            lacks=lacks,
        )


def agree_on_duties(board: Board[ArduinoProtocol], motor: str, *, goes_by_duty: bool) -> None:
    """Have the board's motors told duties, or counts; raises DeviceError where it cannot, or the other one differs."""
    if goes_by_duty and not board.protocol.firmware.takes_duties:
        require_ours(board, motor, "takes no duties", "leave model out of both motors")
    if board.protocol.goes_by_duty not in (None, goes_by_duty):
        fault = f"one motor on {board.line.place} has a model, and one has none"
        raise DeviceError(motor, f"{fault}. Give both one, or none", kind="motors-differ", place=board.line.place)
    board.protocol.goes_by_duty = goes_by_duty
