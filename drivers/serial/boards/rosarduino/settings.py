"""What a robot's file says of the devices on such a board, and what whoever connects one must know."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from drivers.serial.boards.settings import PortSettings, SideSettings, TimeoutSettings
from robotcore.description import EncoderDescription
from robotcore.hardware.motors import Control, Model

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
    "A turn of the wheel is {edges} edges of the encoder's two channels, as counts_per_turn = {told} and counts = "
    '"{counts}" have it. A wheel that has a quarter of them turns four times as fast as it is told: count them once, '
    "as docs/firmware.md says."
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


def edges_per_turn(told: EncoderDescription, counts: object) -> int:
    """Return how far a board counts on a turn of the wheel: all four edges of each cycle."""
    return told.counts_per_turn * (1 if counts == "edges" else 4)
