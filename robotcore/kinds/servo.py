"""A servo, which turns to an angle and holds it."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from robotcore.description import DeviceDescription, Mount
from robotcore.description.types import Radians
from robotcore.errors import Mistake
from robotcore.geometry import to_float
from robotcore.hal.device import Actuator, build_invalid_command
from robotcore.hal.kind import Kind, assert_limited, assert_refused
from robotcore.hal.robot import Robot
from robotcore.hal.simulation_state import SimulationState
from robotcore.kinds.device_tests.servos import test_servos

__all__ = ["KIND", "Servo", "ServoDescription"]


class ServoDescription(DeviceDescription):
    """A servo, which turns to an angle and holds it.

    >>> pan = ServoDescription(kind="servo", name="pan", min_angle_rad=0.2, max_angle_rad=1.5, max_velocity_rad_s=5.0)
    >>> pan.rest_angle_rad  # before the first command
    0.2
    """

    kind: Literal["servo"]
    mount: Mount | None = None
    """The place of the servo, whose axis is vertical. Devices with ``on`` in their mount turn about it."""
    min_angle_rad: Radians
    """The least angle, in radians."""
    max_angle_rad: Radians
    """The greatest angle, in radians."""
    max_velocity_rad_s: Annotated[float, Field(ge=0.001, le=1e4)]
    """The rate at which the servo turns, in rad/s. A servo without feedback is assumed to turn at this rate."""

    @model_validator(mode="after")
    def _require_order(self) -> ServoDescription:
        if self.min_angle_rad >= self.max_angle_rad:
            problem = f"min_angle_rad, {self.min_angle_rad:g}, is not below max_angle_rad, {self.max_angle_rad:g}"
            raise Mistake(problem, "Correct one of them", kind="angles-in-wrong-order")
        return self

    @property
    def rest_angle_rad(self) -> float:
        """The angle before the first command, in radians: the angle within the limits that is nearest to 0."""
        return max(self.min_angle_rad, min(0.0, self.max_angle_rad))

    def arguments(self) -> dict[str, Any]:
        limits = {"min_angle": self.min_angle_rad, "max_angle": self.max_angle_rad}
        return {**limits, "angle": self.rest_angle_rad}


class Servo(Actuator[float], ABC):
    """A servo. A stop does not turn it: it holds its angle.

    min_angle, max_angle: the limits of the angle in radians.

    ``angle`` is the last commanded angle in radians. Before the first command it is the angle within the limits that is
    nearest to 0.

    >>> from robotcore.hal.kind import build_actuator
    >>> from robotcore.kinds.servo import ServoDescription
    >>> limits = {"min_angle_rad": -1.5, "max_angle_rad": 1.5, "max_velocity_rad_s": 5.0}
    >>> servo = build_actuator(ServoDescription(kind="servo", name="pan", **limits), lambda rad: None)
    >>> servo.angle, servo.set_angle(0.5), servo.set_angle(9.0), servo.angle
    (0.0, 0.5, 1.5, 1.5)
    """

    kind = "servo"
    command_unit = "rad"

    def __init__(self, name: str, *, min_angle: float, max_angle: float, angle: float) -> None:
        super().__init__(name)
        self.min_angle, self.max_angle, self.angle = min_angle, max_angle, angle

    def set_angle(self, rad: float) -> float:
        """Send an angle in radians, limited to ``min_angle`` and ``max_angle``, and return the angle that was sent.

        It does not wait until the servo has turned.

        Raises InvalidCommandError, and does not turn the servo, if ``rad`` is NaN or infinite. Raises DeviceError if
        the servo fails.
        """
        self.angle = self.send(to_float(rad))
        return self.angle

    def _limit(self, command: float) -> float:
        if not math.isfinite(command):
            raise build_invalid_command(self.name, f"an angle of {command} rad")
        return max(self.min_angle, min(command, self.max_angle))


def simulate(servo: ServoDescription, state: SimulationState) -> Callable[[float], None]:
    """Return the function that turns the servo's joint to a commanded angle."""
    return state.joints[servo.name].turn_to


def check_commands(_robot: Robot, servo: Servo) -> None:
    """Check that a servo refuses an angle that is not a number, and limits others."""
    assert_refused(servo, math.nan, math.inf)
    assert_limited(servo, {servo.max_angle + 1: servo.max_angle, servo.min_angle - 1: servo.min_angle})


KIND = Kind(
    "a servo, which turns to an angle and holds it",
    ServoDescription,
    Servo,
    simulate=simulate,
    rules=(check_commands,),
    test_devices=test_servos,
)
"""The kind `servo`, which the entry point of this name refers to."""
