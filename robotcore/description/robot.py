"""The robot description: one file that makes the simulators' model and the real robot's wiring.

Frame: origin on the floor under the middle of the axle, x forward, y left, z up. Keys end in their unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Annotated, Any

from pydantic import (
    BeforeValidator,
    Field,
    PrivateAttr,
    ValidationInfo,
    model_validator,
)

from robotcore.description.conditions import Conditions
from robotcore.description.devices import (
    DescriptionT,
    DeviceDescription,
    EncoderDescription,
    MotorDescription,
    Mount,
    RangeSensorDescription,
)
from robotcore.description.types import Colour, Coordinate, Metres, Name, StrictModel, frozen, require_unique
from robotcore.geometry import DifferentialGeometry

UNIT_ERROR_FACTOR = 10
"""What is so many times as wide as the body is in another unit."""


Mass = Annotated[float, Field(ge=1e-4, le=1e4)]
"""The mass of a part, from a tenth of a gram to ten tonnes."""


class Body(StrictModel):
    """A box; its footprint takes in the wheels."""

    length_m: Metres
    width_m: Metres
    height_m: Metres
    centre_x_m: Coordinate = 0.0
    clearance_m: Annotated[float, Field(ge=0, le=100)]
    mass_kg: Mass
    colour: Colour = (60, 65, 75)

    @property
    def front_x_m(self) -> float:
        """Where the body ends ahead of the axle."""
        return self.centre_x_m + self.length_m / 2

    @property
    def footprint(self) -> tuple[tuple[float, float], ...]:
        """Its outline on the floor, counter-clockwise, in the robot's frame."""
        back, left = self.front_x_m - self.length_m, self.width_m / 2
        return ((self.front_x_m, left), (back, left), (back, -left), (self.front_x_m, -left))

    @property
    def middle_m(self) -> tuple[float, float, float]:
        """The middle of the box, where its mass is, in the robot's frame."""
        return (self.centre_x_m, 0.0, self.clearance_m + self.height_m / 2)

    @property
    def moments_kg_m2(self) -> tuple[float, float, float]:
        """Its moments of inertia about x, y and z through its middle: a box's."""
        x, y, z = self.length_m, self.width_m, self.height_m
        twelfth = self.mass_kg / 12
        return (twelfth * (y * y + z * z), twelfth * (x * x + z * z), twelfth * (x * x + y * y))

    @property
    def reach_m(self) -> float:
        """The farthest point of the footprint from the middle of the axle."""
        return max(math.hypot(x, y) for x, y in self.footprint)


class Caster(StrictModel):
    """A ball that slides without friction."""

    x_m: Coordinate
    radius_m: Metres


class Drive(StrictModel):
    """Two driven wheels on one axle; ``left`` and ``right`` name the motors, and encoders where there are any."""

    left: Name
    right: Name
    left_encoder: Name | None = None
    right_encoder: Name | None = None
    track_m: Metres
    wheel_radius_m: Metres
    wheel_width_m: Metres
    wheel_mass_kg: Mass
    caster: Caster | None = None
    max_acceleration_rad_s2: Annotated[float, Field(ge=0.01, le=1e6)] | None = None

    @model_validator(mode="after")
    def _sides_differ(self) -> Drive:
        if self.left == self.right:
            raise ValueError(f"left and right are both {self.left!r}; name two motors")
        if (self.left_encoder is None) != (self.right_encoder is None):
            raise ValueError("one wheel alone has an encoder; name both encoders or neither")
        if self.left_encoder and self.left_encoder == self.right_encoder:
            raise ValueError(f"left and right encoder are both {self.left_encoder!r}; name two encoders")
        return self

    @property
    def on_wheels(self) -> dict[str, str]:
        """The motor of its wheel for each device that sits on one: the motors themselves, and the encoders."""
        sides = ((self.left, self.left_encoder), (self.right, self.right_encoder))
        return {device: motor for motor, encoder in sides for device in (motor, encoder) if device}

    @property
    def wheel_moments_kg_m2(self) -> tuple[float, float, float]:
        """A wheel's moments of inertia about x, its axle and z: a cylinder's."""
        radius, width, mass = self.wheel_radius_m, self.wheel_width_m, self.wheel_mass_kg
        across = mass * (3 * radius**2 + width**2) / 12
        return (across, mass * radius**2 / 2, across)

    def wheel_y_m(self, motor: str) -> float:
        """Return how far to the left of the robot's middle the wheel of one of its motors is."""
        return self.track_m / 2 if motor == self.left else -self.track_m / 2

    @property
    def geometry(self) -> DifferentialGeometry:
        return DifferentialGeometry(self.wheel_radius_m, self.track_m)


class Safety(StrictModel):
    """When the safety stage steps in; see `robotcore.safety`.

    ``watchdog_s`` is how long an app's step may take, ``answer_s`` how long a device or a simulator may let wait;
    ``stuck_m`` is how far the robot may drive, turning too, while a range sensor tells the very same. ``outage_s`` is
    how long a device that is lost, such as one that was unplugged, may be away while the robot stands and waits; 0: the
    run ends.
    """

    stop_distance_m: Metres = 0.10
    deceleration_m_s2: Annotated[float, Field(ge=0.01, le=100)] = 0.5
    lease_ticks: Annotated[float, Field(ge=1, le=10)] = 2.5
    max_age_s: Annotated[float, Field(ge=0.001, le=3600)] = 1.0
    watchdog_s: Annotated[float, Field(ge=0.2, le=3600)] = 3.0
    answer_s: Annotated[float, Field(ge=0.2, le=3600)] = 1.0
    follow_s: Annotated[float, Field(ge=0.01, le=3600)] = 1.5
    stuck_m: Metres = 0.5
    outage_s: Annotated[float, Field(ge=0, le=3600)] = 0.0


@dataclass(frozen=True)
class _Origin:
    """Where a description comes from, which makes no difference: all are equal."""

    file: str | None = field(default=None, compare=False)


class RobotDescription(StrictModel):
    """A robot: a body, perhaps a drive, devices, and what a single backend needs besides.

    Where it is validated with the context ``{"file": …}``, that is the user's own file which it is from.
    """

    name: Name
    summary: str = ""
    body: Body
    drive: Drive | None = None
    safety: Safety = Safety()
    devices: Annotated[tuple[DeviceDescription, ...], Field(description="a list of tables: [[devices]]")] = ()
    backends: Annotated[dict[str, dict[str, Any]], BeforeValidator(frozen)] = Field(default_factory=dict)
    _origin: _Origin = PrivateAttr(default_factory=_Origin)

    @model_validator(mode="after")
    def _is_from(self, info: ValidationInfo) -> RobotDescription:
        if info.context and "file" in info.context:
            self._origin = _Origin(info.context["file"])
        return self

    @model_validator(mode="after")
    def _names_fit(self) -> RobotDescription:
        require_unique("devices", (device.name for device in self.devices))
        if drive := self.drive:
            motors = {motor.name for motor in self.all_of(MotorDescription)}
            encoders = {encoder.name for encoder in self.all_of(EncoderDescription)}
            _require_named("drive", (drive.left, drive.right), motors, "motor")
            _require_named("drive", filter(None, (drive.left_encoder, drive.right_encoder)), encoders, "encoder")
        return self

    @model_validator(mode="after")
    def _wheels_fit(self) -> RobotDescription:
        if (drive := self.drive) is None:
            return self
        body, across = self.body, drive.track_m + drive.wheel_width_m
        if drive.wheel_radius_m > body.length_m:
            raise ValueError(
                f"a wheel's radius is {drive.wheel_radius_m:g} m, and the body with its wheels {body.length_m:g} m "
                "long; give drive.wheel_radius_m in metres"
            )
        for key in ("track_m", "wheel_width_m"):
            if (given := getattr(drive, key)) > UNIT_ERROR_FACTOR * body.width_m:
                raise ValueError(
                    f"drive.{key} is {given:g}, and the body with its wheels {body.width_m:g} m wide; give it in metres"
                )
        if across > body.width_m:
            raise ValueError(
                f"the wheels are {across:g} m from outside to outside, the body is {body.width_m:g} m wide; "
                "let body.width_m take in the wheels"
            )
        if not body.front_x_m - body.length_m < 0 < body.front_x_m:
            raise ValueError("the axle is not under the body; correct body.centre_x_m or body.length_m")
        if body.clearance_m == 0:
            raise ValueError("the body lies on the floor; raise body.clearance_m, or leave out [drive]")
        return self

    @property
    def mounts(self) -> dict[str, Mount]:
        """Where each sensor that looks somewhere sits."""
        mounts = {device.name: getattr(device, "mount", None) for device in self.devices}
        return {sensor: mount for sensor, mount in mounts.items() if isinstance(mount, Mount)}

    @property
    def file(self) -> str | None:
        """The user's own file that it is from, as it was named; None where there is none."""
        return self._origin.file

    @property
    def source(self) -> str:
        """What it is called where it is wrong: its file, or ``robot NAME``."""
        return self.file or f"robot {self.name}"

    @property
    def range_sensors_ahead(self) -> tuple[RangeSensorDescription, ...]:
        """The range sensors that look where the robot drives: the range guard's."""
        return tuple(sensor for sensor in self.all_of(RangeSensorDescription) if sensor.mount.looks_ahead)

    def all_of(self, kind: type[DescriptionT]) -> tuple[DescriptionT, ...]:
        """Return the devices of one kind, in the order of the file."""
        return tuple(device for device in self.devices if isinstance(device, kind))

    def under(self, conditions: Conditions) -> RobotDescription:
        """Return the robot as it is to be simulated: its wheels lag as a world's conditions say, where they do."""
        lag, drive = conditions.wheel_lag_s, self.drive
        if lag is None or drive is None:
            return self
        wheels = (drive.left, drive.right)
        devices = (d.model_copy(update={"lag_s": lag}) if d.name in wheels else d for d in self.devices)
        return self.model_copy(update={"devices": tuple(devices)})

    def first_of(self, kind: type[DescriptionT]) -> DescriptionT | None:
        """Return the first device of one kind: the one that fills the role."""
        return next(iter(self.all_of(kind)), None)


def _require_named(who: str, names: Iterable[str], known: set[str], kind: str) -> None:
    for name in names:
        if name not in known:
            raise ValueError(
                f"{who} names the {kind} {name!r}, which is not among the devices; "
                f'add [[devices]] with kind = "{kind}" and that name'
            )
