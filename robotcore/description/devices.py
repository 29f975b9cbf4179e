"""The descriptions of a robot's devices.

Robot frame: origin on the floor under the middle of the axle, x forward, y left, z up. Keys end in their unit.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, TypeVar

from pydantic import (
    AfterValidator,
    Field,
    model_validator,
)

from robotcore.description.types import Coordinate, InvalidValueError, Name, Radians, StrictModel
from robotcore.optics import Intrinsics

LEAST_LAG_S = 1e-4
"""The shortest lag other than 0. A shorter one has no effect, because the time steps of simulators are longer."""


def _require_measurable_lag(lag: float) -> float:
    if 0 < lag < LEAST_LAG_S:
        raise InvalidValueError(
            "lag-too-short", f"is {lag:g} s, shorter than any simulator's step; use 0, or at least {LEAST_LAG_S:g} s"
        )
    return lag


AHEAD_RAD = math.pi / 4
"""A sensor within this angle of the x axis points ahead."""

SensorRange = Annotated[float, Field(ge=1e-4, le=1000)]
"""A distance that a range sensor measures, in metres."""


class Mount(StrictModel):
    """The position and the direction of a sensor in the robot's frame."""

    x_m: Coordinate = 0.0
    """Forward of the axle."""
    y_m: Coordinate = 0.0
    """To the left of the middle."""
    z_m: Annotated[float, Field(ge=0, le=100)]
    """Above the floor."""
    yaw_rad: Radians = 0.0
    """The angle to the left between the robot's x axis and the sensor's direction."""
    pitch_rad: Radians = 0.0
    """The angle downwards between the horizontal and the sensor's direction."""

    @property
    def is_ahead(self) -> bool:
        """Whether the sensor points ahead, within 45° of the robot's x axis."""
        return math.cos(self.yaw_rad) * math.cos(self.pitch_rad) > math.cos(AHEAD_RAD)


class MotorDescription(StrictModel):
    """A motor. Its velocity follows the command with a first-order lag."""

    kind: Literal["motor"]
    name: Name
    max_velocity_rad_s: Annotated[float, Field(ge=0.001, le=1e4)]
    """The greatest velocity of the wheel, forward and backward."""
    lag_s: Annotated[float, Field(ge=0, le=10), AfterValidator(_require_measurable_lag)] = 0.05
    """The time constant of the lag."""
    max_torque_nm: Annotated[float, Field(ge=1e-6, le=1e4)] = 0.08
    """The greatest torque at the wheel."""


class EncoderDescription(StrictModel):
    """An incremental encoder on a wheel."""

    kind: Literal["encoder"]
    name: Name
    counts_per_turn: Annotated[int, Field(ge=1, le=10**7)]
    """The number of counts in one turn of the wheel."""

    def quantise(self, angle: float) -> float:
        """Return the angle of the nearest whole count, in radians.

        The angle is rounded to the nearest count, not down. Otherwise a wheel at rest near 0 might read -1 count.
        """
        count = math.tau / self.counts_per_turn
        return round(angle / count) * count


class BatteryDescription(StrictModel):
    """A battery whose voltage a driver measures."""

    kind: Literal["battery"]
    name: Name
    warn_below_v: Annotated[float, Field(ge=0.1, le=1000)] | None = None
    """Below this voltage, robotcore warns that the battery must be charged. With None there is no warning."""


class RangeSensorDescription(StrictModel):
    """A distance sensor with a cone-shaped beam."""

    kind: Literal["range_sensor"]
    name: Name
    mount: Mount
    min_range_m: SensorRange
    """The shortest distance that the sensor measures. A nearer object reads as this distance."""
    max_range_m: SensorRange
    """The longest distance that the sensor measures. For a farther object, the sensor returns ``inf``."""
    cone_rad: Annotated[float, Field(ge=0, lt=math.pi)]
    """The full opening angle of the cone."""

    @model_validator(mode="after")
    def _ranges_in_order(self) -> RangeSensorDescription:
        if self.min_range_m >= self.max_range_m:
            raise InvalidValueError(
                "ranges-in-wrong-order",
                f"min_range_m {self.min_range_m:g} is not below max_range_m {self.max_range_m:g}; correct either",
            )
        return self


class CameraDescription(StrictModel):
    """A pinhole camera."""

    kind: Literal["camera"]
    name: Name
    mount: Mount
    width_px: Annotated[int, Field(ge=16, le=4096)]
    """The width of a picture."""
    height_px: Annotated[int, Field(ge=16, le=4096)]
    """The height of a picture."""
    horizontal_fov_rad: Annotated[float, Field(ge=0.01, le=3)]
    """The full horizontal field of view. The vertical one follows from it, because pixels are square."""

    @property
    def intrinsics(self) -> Intrinsics:
        return Intrinsics(self.width_px, self.height_px, self.horizontal_fov_rad)


class DisplayDescription(StrictModel):
    """A display that shows the pictures that an app sends."""

    kind: Literal["display"]
    name: Name


SimulatedDevice = (
    MotorDescription | EncoderDescription | RangeSensorDescription | CameraDescription | DisplayDescription
)
"""The devices that a simulator opens. It has no battery."""

AnyDevice = SimulatedDevice | BatteryDescription
DeviceDescription = Annotated[AnyDevice, Field(discriminator="kind")]
DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
