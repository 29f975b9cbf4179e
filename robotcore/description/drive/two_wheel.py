"""A differential drive."""

from __future__ import annotations

from typing import Literal

from pydantic import model_validator

from robotcore.description.drive.base import Caster, Drive, DriveWheel, require_two_encoders
from robotcore.description.types import Name
from robotcore.errors import Mistake


class TwoWheelDrive(Drive):
    """A differential drive: two driven wheels on one axle.

    >>> size = {"track_m": 0.155, "wheel_radius_m": 0.0325, "wheel_width_m": 0.026, "wheel_mass_kg": 0.06}
    >>> TwoWheelDrive(left="left_motor", right="right_motor", **size).geometry
    DifferentialGeometry(wheel_radius=0.0325, track=0.155)
    """

    kind: Literal["differential"] = "differential"
    left: Name
    """The name of the left motor."""
    right: Name
    """The name of the right motor."""
    left_encoder: Name | None = None
    """The name of the left wheel's encoder."""
    right_encoder: Name | None = None
    """The name of the right wheel's encoder."""
    caster: Caster | None = None

    @model_validator(mode="after")
    def _require_two_sides(self) -> TwoWheelDrive:
        if self.left == self.right:
            raise Mistake(f"left and right are the same motor {self.left!r}", "Name two motors", kind="same-motor")
        require_two_encoders(self.left_encoder, self.right_encoder)
        return self

    @property
    def left_motors(self) -> tuple[str, ...]:
        return (self.left,)

    @property
    def right_motors(self) -> tuple[str, ...]:
        return (self.right,)

    @property
    def left_encoders(self) -> tuple[str, ...]:
        return (self.left_encoder,) if self.left_encoder else ()

    @property
    def right_encoders(self) -> tuple[str, ...]:
        return (self.right_encoder,) if self.right_encoder else ()

    @property
    def wheels(self) -> tuple[DriveWheel, ...]:
        y_m = self.track_m / 2
        return (
            DriveWheel(self.left, 0.0, y_m, self.left, self.left_encoder),
            DriveWheel(self.right, 0.0, -y_m, self.right, self.right_encoder),
        )
