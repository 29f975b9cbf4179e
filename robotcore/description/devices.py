"""The robot description: one file that makes the simulators' model and the real robot's wiring.

Frame: origin on the floor under the middle of the axle, x forward, y left, z up. Keys end in their unit.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, TypeVar

from pydantic import (
    AfterValidator,
    Field,
    model_validator,
)

from robotcore.description.types import Angle, Coordinate, Name, StrictModel
from robotcore.optics import Intrinsics

LEAST_LAG_S = 1e-4
"""A shorter lag is none: no simulator takes such short steps."""


def _require_measurable_lag(lag: float) -> float:
    if 0 < lag < LEAST_LAG_S:
        raise ValueError(f"is {lag:g} s, shorter than any simulator's step; use 0, or at least {LEAST_LAG_S:g} s")
    return lag


AHEAD_RAD = math.pi / 4

Range = Annotated[float, Field(ge=1e-4, le=1000)]
"""A distance that a range sensor measures, in metres."""


class Mount(StrictModel):
    """Where on the robot a sensor sits and where it looks; pitch is positive downwards."""

    x_m: Coordinate = 0.0
    y_m: Coordinate = 0.0
    z_m: Annotated[float, Field(ge=0, le=100)]
    yaw_rad: Angle = 0.0
    pitch_rad: Angle = 0.0

    @property
    def looks_ahead(self) -> bool:
        """Whether it looks where the robot drives, and not aside or at the floor."""
        return math.cos(self.yaw_rad) * math.cos(self.pitch_rad) > math.cos(AHEAD_RAD)


class MotorDescription(StrictModel):
    """A wheel's motor: a first-order lag towards the commanded velocity."""

    kind: Literal["motor"]
    name: Name
    max_velocity_rad_s: Annotated[float, Field(ge=0.001, le=1e4)]
    lag_s: Annotated[float, Field(ge=0, le=10), AfterValidator(_require_measurable_lag)] = 0.05
    max_torque_nm: Annotated[float, Field(ge=1e-6, le=1e4)] = 0.08


class EncoderDescription(StrictModel):
    """A counter on a wheel."""

    kind: Literal["encoder"]
    name: Name
    counts_per_turn: Annotated[int, Field(ge=1, le=10**7)]

    def quantised(self, angle: float) -> float:
        """Return the angle of the nearest whole count, in radians: a wheel that stands a hair off 0 has not turned."""
        count = math.tau / self.counts_per_turn
        return round(angle / count) * count


class BatteryDescription(StrictModel):
    """A battery whose voltage somebody tells; below ``warn_below_v`` it is to be charged."""

    kind: Literal["battery"]
    name: Name
    warn_below_v: Annotated[float, Field(ge=0.1, le=1000)] | None = None


class RangeSensorDescription(StrictModel):
    """A distance sensor; ``cone_rad`` is the full angle."""

    kind: Literal["range_sensor"]
    name: Name
    mount: Mount
    min_range_m: Range
    max_range_m: Range
    cone_rad: Annotated[float, Field(ge=0, lt=math.pi)]

    @model_validator(mode="after")
    def _ranges_in_order(self) -> RangeSensorDescription:
        if self.min_range_m >= self.max_range_m:
            raise ValueError(
                f"min_range_m {self.min_range_m:g} is not below max_range_m {self.max_range_m:g}; correct either"
            )
        return self


class CameraDescription(StrictModel):
    """A pinhole camera."""

    kind: Literal["camera"]
    name: Name
    mount: Mount
    width_px: Annotated[int, Field(ge=16, le=4096)]
    height_px: Annotated[int, Field(ge=16, le=4096)]
    horizontal_fov_rad: Annotated[float, Field(ge=0.01, le=3)]

    @property
    def intrinsics(self) -> Intrinsics:
        return Intrinsics(self.width_px, self.height_px, self.horizontal_fov_rad)


class DisplayDescription(StrictModel):
    """Where an app's annotated picture goes."""

    kind: Literal["display"]
    name: Name


SimulatedDevice = (
    MotorDescription | EncoderDescription | RangeSensorDescription | CameraDescription | DisplayDescription
)
"""What a simulator opens: it has no battery to tell of."""

AnyDevice = SimulatedDevice | BatteryDescription
DeviceDescription = Annotated[AnyDevice, Field(discriminator="kind")]
DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
