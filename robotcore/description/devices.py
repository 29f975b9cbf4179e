"""The descriptions of a robot's devices.

The origin of the robot's frame is on the floor under the middle of the axle. In this frame, x points forward, y left
and z up. Keys end in their unit.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, TypeVar

from pydantic import (
    AfterValidator,
    Field,
    model_validator,
)

from robotcore.description.types import Coordinate, Name, Radians, StrictModel
from robotcore.errors import Mistake
from robotcore.optics import Intrinsics

MIN_LAG_S = 1e-4
"""The shortest lag other than 0, in seconds. Simulators have longer time steps, so a shorter lag has no effect."""


def _require_measurable_lag(lag: float) -> float:
    if 0 < lag < MIN_LAG_S:
        problem = f"is {lag:g} s, shorter than a simulator's time step"
        raise Mistake(problem, f"Use 0, or at least {MIN_LAG_S:g} s", kind="lag-too-short")
    return lag


AHEAD_RAD = math.pi / 4
"""The greatest angle, in radians, from the robot's x axis to the direction of a sensor that points ahead."""

SensorRange = Annotated[float, Field(ge=1e-4, le=1000)]
"""The shortest or the longest distance that a range sensor measures, in metres."""


class Mount(StrictModel):
    """The position and the direction of a sensor in the robot's frame."""

    x_m: Coordinate = 0.0
    """The distance from the axle forward to the sensor, in metres."""
    y_m: Coordinate = 0.0
    """The distance of the sensor to the left of the robot's middle, in metres."""
    z_m: Annotated[float, Field(ge=0, le=100)]
    """The height of the sensor above the floor, in metres."""
    yaw_rad: Radians = 0.0
    """The angle from the robot's x axis to the sensor's direction, in radians, positive to the left."""
    pitch_rad: Radians = 0.0
    """The angle from the horizontal to the sensor's direction, in radians, positive downwards."""

    @property
    def is_ahead(self) -> bool:
        """Whether the sensor's direction is less than 45° from the robot's x axis."""
        return math.cos(self.yaw_rad) * math.cos(self.pitch_rad) > math.cos(AHEAD_RAD)


class MotorDescription(StrictModel):
    """A motor of a wheel. The wheel's velocity follows the command with a first-order lag."""

    kind: Literal["motor"]
    name: Name
    max_velocity_rad_s: Annotated[float, Field(ge=0.001, le=1e4)]
    """The greatest velocity of the wheel, forward and backward, in rad/s."""
    lag_s: Annotated[float, Field(ge=0, le=10), AfterValidator(_require_measurable_lag)] = 0.05
    """The time constant of the wheel's lag, in seconds."""
    max_torque_nm: Annotated[float, Field(ge=1e-6, le=1e4)] = 0.08
    """The greatest torque at the wheel, in N·m."""


class EncoderDescription(StrictModel):
    """An incremental encoder on a wheel."""

    kind: Literal["encoder"]
    name: Name
    counts_per_turn: Annotated[int, Field(ge=1, le=10**7)]
    """The number of counts in one turn of the wheel."""

    def quantise(self, angle: float) -> float:
        """Return the angle in radians, rounded to the nearest whole count."""
        # Rounded down, a wheel at rest near 0 would sometimes have -1 count.
        count = math.tau / self.counts_per_turn
        return round(angle / count) * count


class BatteryDescription(StrictModel):
    """A battery whose voltage is measured."""

    kind: Literal["battery"]
    name: Name
    warn_below_v: Annotated[float, Field(ge=0.1, le=1000)] | None = None
    """The voltage, in volts, below which the user is warned to charge the battery; None for no warning."""


class RangeSensorDescription(StrictModel):
    """A sensor that measures the distance to the nearest body in a cone."""

    kind: Literal["range_sensor"]
    name: Name
    mount: Mount
    min_range_m: SensorRange
    """The shortest distance that the sensor measures, in metres. A nearer body is measured at this distance."""
    max_range_m: SensorRange
    """The longest distance that the sensor measures, in metres. For a farther body, the sensor returns ``inf``."""
    cone_rad: Annotated[float, Field(ge=0, lt=math.pi)]
    """The full opening angle of the cone, in radians."""

    @model_validator(mode="after")
    def _ranges_in_order(self) -> RangeSensorDescription:
        if self.min_range_m >= self.max_range_m:
            problem = f"min_range_m, {self.min_range_m:g} m, is not below max_range_m, {self.max_range_m:g} m"
            raise Mistake(problem, "Correct one of them", kind="ranges-in-wrong-order")
        return self


class CameraDescription(StrictModel):
    """A camera, which simulators model as a pinhole camera."""

    kind: Literal["camera"]
    name: Name
    mount: Mount
    width_px: Annotated[int, Field(ge=16, le=4096)]
    """The width of a picture, in pixels."""
    height_px: Annotated[int, Field(ge=16, le=4096)]
    """The height of a picture, in pixels."""
    horizontal_fov_rad: Annotated[float, Field(ge=0.01, le=3)]
    """The full horizontal field of view, in radians. Pixels are square, so the vertical field of view follows."""

    @property
    def intrinsics(self) -> Intrinsics:
        return Intrinsics(self.width_px, self.height_px, self.horizontal_fov_rad)


class DisplayDescription(StrictModel):
    """A display that shows the pictures of an app."""

    kind: Literal["display"]
    name: Name


SimulatedDevice = (
    MotorDescription | EncoderDescription | RangeSensorDescription | CameraDescription | DisplayDescription
)
"""The descriptions of the devices that a simulator can open: all except batteries."""

AnyDevice = SimulatedDevice | BatteryDescription
DeviceDescription = Annotated[AnyDevice, Field(discriminator="kind")]
DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
