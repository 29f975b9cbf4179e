"""What a robot's file says of a hoverboard's devices."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from drivers.serial.boards.hoverboard.mixer import Mixed, Mixer, Tank
from drivers.serial.boards.hoverboard.protocol import LIMIT
from drivers.serial.boards.settings import PortSettings, SideSettings
from robotcore.description import MotorDescription, RobotDescription
from robotcore.hardware import Connection
from robotcore.hardware.motors import Control, Model, require_drivable


class HoverboardSettings(PortSettings):
    """The port; the board's own time-out is in its firmware (SERIAL_TIMEOUT, 0.8 s) and cannot be set."""

    speaks: ClassVar[str] = "Hoverboard FOC"
    usual_baud: ClassVar[int] = 115200


class WheelSettings(SideSettings, HoverboardSettings):
    """One of the board's two wheels; ``inverted`` where its driver turns or counts it the wrong way."""

    inverted: bool = False

    @property
    def sign(self) -> int:
        return -1 if self.inverted else 1


class HoverboardMotorSettings(WheelSettings):
    """What the firmware was built with, by its config.h: the driver cannot ask, and the two motors say the same.

    ``mode`` is CTRL_MOD_REQ: "speed" is SPD_MODE, where the board holds the velocity and ``max_rpm`` is N_MOT_MAX;
    "duty" is VLT_MODE, where the wheel turns by ``model``, and ``control`` by its encoder. ``tank_steering`` is whether
    TANK_STEERING is defined; where it is not, ``speed_coefficient`` and ``steer_coefficient`` are those of the mixer,
    divided by 16384.
    """

    mode: Literal["speed", "duty"]
    max_rpm: Annotated[int, Field(ge=10, le=2000)] = 1000
    tank_steering: bool = False
    speed_coefficient: Annotated[float, Field(ge=0.1, lt=2)] = 1.0
    steer_coefficient: Annotated[float, Field(ge=0.1, lt=2)] = 0.5
    model: Model | None = None
    control: Control | None = None

    @property
    def mixer(self) -> Mixer:
        return Tank() if self.tank_steering else Mixed(self.speed_coefficient, self.steer_coefficient)

    @property
    def unit_per_rad_s(self) -> float:
        """What the board is told for 1 rad/s in its own closed loop."""
        return self.sign * LIMIT / self.max_rpm * 60 / math.tau

    def firmware(self) -> Connection:
        """Return what both motors of a board must say alike, as something that they share."""
        built = f"mode {self.mode}, {self.max_rpm} rpm, {self.mixer}"
        instead = "say the same of it for both motors"
        return Connection(
            "firmware", "config.h of the board at", self.port, is_shared=True, instead=instead, spoken=built
        )

    def check(self, told: MotorDescription, robot: RobotDescription) -> None:
        """Raise ValueError, the fault, a semicolon and the remedy, where the board cannot turn the wheel so."""
        if self.mode == "duty":
            self._check_duty(told, robot)
        elif self.model or self.control:
            raise ValueError("in mode speed the board holds the velocity; leave model and control out")
        elif told.max_velocity_rad_s > (reach := self.mixer.straight / abs(self.unit_per_rad_s)):
            raise ValueError(
                f"the board turns a wheel at {reach:.3g} rad/s at most, and max_velocity_rad_s of {told.name} is "
                f"{told.max_velocity_rad_s:g}; lower that, or correct max_rpm or speed_coefficient"
            )

    def _check_duty(self, told: MotorDescription, robot: RobotDescription) -> None:
        if self.model is None:
            raise ValueError("in mode duty the wheel turns by its model; add one, or build the board with SPD_MODE")
        if self.model.max_duty > (straight := self.mixer.straight / LIMIT):
            raise ValueError(
                f"the board's mixer makes a duty of {straight:g} at most, and model.max_duty is "
                f"{self.model.max_duty:g}; lower that, or correct speed_coefficient"
            )
        require_drivable(told, self.model, self.control, robot)
