"""Doubles of a simulator's devices, which a test sets."""

from __future__ import annotations

from typing import Any

from robotcore.description import RobotDescription, load_robot
from robotcore.hal.devices import Angle, Encoder, Motor, Range, RangeSensor


class FakeMotor(Motor):
    """A motor that keeps its last velocity."""

    def __init__(self) -> None:
        super().__init__("motor", 12.0)
        self.velocity = 0.0

    def _apply(self, rad_s: float) -> None:
        self.velocity = rad_s


class FakeEncoder(Encoder):
    """An encoder that returns the angle that a test has set."""

    def __init__(self) -> None:
        super().__init__("encoder")
        self.angle = 0.0

    def _newest(self) -> Angle:
        return Angle(self.angle, 0.0, 0)


class FakeRange(RangeSensor):
    """A range sensor that returns the distance that a test has set."""

    def __init__(self, distance: float) -> None:
        super().__init__("nose", min_range=0.02, max_range=4.3, cone=0.5)
        self.distance = distance

    def _newest(self) -> Range:
        return Range(self.distance, 0.0, 0)


MODEL = {"dead_band": 0.05, "forward_rad_s": 16.0, "backward_rad_s": 15.0}


def rewire(**motor: Any) -> RobotDescription:
    """Return the rover with phase-enable boards and one-channel encoders."""
    rover = load_robot("rover")
    section = rover.backends["raspberrypi"] | {
        "left_motor": {"driver": "phase-enable", "phase": 17, "enable": 27, "model": MODEL, **motor},
        "right_motor": {"driver": "phase-enable", "phase": 23, "enable": 24, "model": MODEL, **motor},
        "left_encoder": {"driver": "pulses", "gpio": 5},
        "right_encoder": {"driver": "pulses", "gpio": 20},
    }
    return rover.model_copy(update={"backends": rover.backends | {"raspberrypi": section}})
