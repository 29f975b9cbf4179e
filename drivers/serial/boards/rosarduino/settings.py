"""The settings of an Arduino's devices, their checks, and the notes that `robotcore wiring` prints."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from drivers.serial.boards.rosarduino.protocol import FASTEST
from drivers.serial.driver import PortSettings, SideSettings, TimeoutSettings
from robotcore.description import EncoderDescription, MotorDescription, RobotDescription
from robotcore.hardware import encoder_of
from robotcore.hardware.motor_control import Control
from robotcore.hardware.motor_model import Model

BRIDGE_CYCLE_S = 0.06
"""The period in which robotcore_bridge triggers its ultrasonic module, in seconds."""

ECHO_FREE_S = 0.6
"""The default time without an echo, in seconds, after which nothing is in range."""

BOARD = (
    "The board runs ROSArduinoBridge, or robotcore_bridge, which robotcore firmware flash writes to it. "
    "robotcore_bridge stops sooner, adds checksums, and measures range and battery at any time. The pins are in the "
    "firmware's config.h and in docs/firmware.md."
)
TIMEOUT = (
    "ROSArduinoBridge always stops the motors 2 s after the last command; robotcore_bridge stops them after "
    "board_timeout_s."
)
COUNTING = (
    "The board takes whole counts in 1/30 s. set_velocity returns the velocity of the nearest whole number, and 0 for "
    "less than half a count."
)
EDGES = (
    'With counts_per_turn = {counts_per_turn} and counts = "{counts}", a turn of the wheel has {edges} edges of the '
    "encoder's two channels. If a turn really has a quarter of these edges, the wheel turns four times too fast. Check "
    "the count once as docs/firmware.md describes."
)
UNPINNED = (
    "robotcore_bridge has the module's pins in its config.h. For ROSArduinoBridge, add the pin of the module, such as "
    "pin = 4."
)
PINGING = (
    "ROSArduinoBridge does nothing else while it waits for an echo: 38 ms without an echo, and 1 s without a module at "
    "that pin. In this time it does not control the velocity and takes no stop."
)


class ArduinoSettings(PortSettings):
    """The settings of a device of an Arduino."""

    protocol_name: ClassVar[str] = "ROSArduinoBridge"
    default_baud: ClassVar[int] = 57600


class ArduinoEncoderSettings(SideSettings, ArduinoSettings):
    """The settings of an encoder on an Arduino."""

    counts: Literal["cycles", "edges"] = "cycles"
    """The unit of ``counts_per_turn`` in the robot's description.

    "cycles" are the cycles of one channel: the PPR of a data sheet, or the slots of a disc. "edges" are the edges of
    both channels, four in each cycle, often called CPR. A turn is a turn of the wheel, not of the motor
    in front of a gear."""


class ArduinoMotorSettings(SideSettings, TimeoutSettings, ArduinoSettings):
    """The settings of a motor on an Arduino.

    Without a ``model`` the board controls the velocity by the wheel's encoder, which is on the same board.
    """

    model: Model | None = None
    """The velocity of the wheel at each duty. With a model, the driver sends duties."""
    control: Control | None = None
    """The settings of velocity control by this process and the wheel's encoder. They need ``model``."""


class ArduinoSonarSettings(ArduinoSettings):
    """The settings of an ultrasonic module on an Arduino."""

    pin: Annotated[int, Field(ge=2, le=69)] | None = None
    """The module's pin on the Arduino. Only ROSArduinoBridge needs it; robotcore_bridge has it in config.h."""
    cycle_s: Annotated[float, Field(ge=0.05, le=1)] = 0.1
    """The period of measuring with ROSArduinoBridge, in seconds. The period of robotcore_bridge is always 0.06 s."""
    echo_free_cycles: Annotated[int, Field(ge=0, le=100)] | None = None
    """After this many cycles in a row without an echo, the distance is `inf`. None means the cycles in 0.6 s.

    With 0, only an echo from beyond the maximum range makes the distance `inf`."""

    @property
    def cycle(self) -> float:
        """The period of measuring in seconds: that of robotcore_bridge if no pin is set, else ``cycle_s``."""
        return BRIDGE_CYCLE_S if self.pin is None else self.cycle_s

    @property
    def cycles(self) -> int:
        """The number of cycles in a row without an echo after which the distance is `inf`."""
        return max(1, round(ECHO_FREE_S / self.cycle)) if self.echo_free_cycles is None else self.echo_free_cycles


def edges_per_turn(description: EncoderDescription, counts: object) -> int:
    """Return the edges in a turn of the wheel. The board counts all edges, four in each cycle.

    counts: the setting ``counts`` of the encoder, "cycles" or "edges".
    """
    return description.counts_per_turn * (1 if counts == "edges" else 4)


ENCODER = "ros-arduino-encoder"
"""The name of the driver of encoders on an Arduino."""

CONTROL_RATE_HZ = 30
"""The rate of the board's velocity control. It takes counts in a period of it."""


def counts_per_turn(motor: str, settings: ArduinoMotorSettings, robot: RobotDescription) -> int:
    """Return the board's counts in a turn of a motor's wheel, from the settings of the wheel's encoder.

    Raises ValueError if the robot's file has no encoder of this wheel on the motor's port.
    """
    name, elsewhere = encoder_of(motor, robot), ""
    for description in robot.all_of(EncoderDescription):
        for section in robot.backends.values():
            found = section.get(name) if description.name == name else None
            table = found if isinstance(found, dict) else {}  # the check of the encoder reports another type
            if table.get("driver") == ENCODER and table.get("port") == settings.port:
                return edges_per_turn(description, table.get("counts"))
            elsewhere = table.get("port", elsewhere) if table.get("driver") == ENCODER else elsewhere
    if elsewhere:
        raise ValueError(
            f"the board of {motor} is on {settings.port} and needs the encoder {name}, which is on {elsewhere}; write "
            "the same port for both"
        )
    raise ValueError(
        f"the board controls the velocity of {motor} by its wheel's encoder, but no encoder is on {settings.port}; "
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
