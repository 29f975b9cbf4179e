"""The description of a robot: its body, drive, safety limits and devices.

Robot frame: origin on the floor under the middle of the axle, x forward, y left, z up. Keys end in their unit.
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
from robotcore.description.types import (
    Colour,
    Coordinate,
    InvalidValueError,
    Metres,
    Name,
    StrictModel,
    freeze,
    require_unique,
)
from robotcore.geometry import DifferentialGeometry

UNIT_ERROR_FACTOR = 10
"""If a wheel's size is this many times the body's, one of the two is probably not given in metres."""


Mass = Annotated[float, Field(ge=1e-4, le=1e4)]
"""The mass of a part, from a tenth of a gram to ten tonnes."""


class Body(StrictModel):
    """The robot's body, a box. Its length and width include the wheels."""

    length_m: Metres
    """The distance from the rear to the front, wheels included."""
    width_m: Metres
    """The distance from side to side, wheels included."""
    height_m: Metres
    """The distance from the bottom to the top."""
    centre_x_m: Coordinate = 0.0
    """The distance from the axle forward to the middle of the body."""
    clearance_m: Annotated[float, Field(ge=0, le=100)]
    """The distance from the floor up to the bottom of the body."""
    mass_kg: Mass
    """The mass without the wheels."""
    colour: Colour = (60, 65, 75)

    @property
    def front_x_m(self) -> float:
        """The distance from the axle forward to the front of the body."""
        return self.centre_x_m + self.length_m / 2

    @property
    def footprint(self) -> tuple[tuple[float, float], ...]:
        """The four corners on the floor, counter-clockwise, in the robot's frame."""
        back, left = self.front_x_m - self.length_m, self.width_m / 2
        return ((self.front_x_m, left), (back, left), (back, -left), (self.front_x_m, -left))

    @property
    def middle_m(self) -> tuple[float, float, float]:
        """The middle of the box in the robot's frame. It is also the centre of mass."""
        return (self.centre_x_m, 0.0, self.clearance_m + self.height_m / 2)

    @property
    def moments_kg_m2(self) -> tuple[float, float, float]:
        """The moments of inertia of the solid box about x, y and z through its middle."""
        x, y, z = self.length_m, self.width_m, self.height_m
        twelfth = self.mass_kg / 12
        return (twelfth * (y * y + z * z), twelfth * (x * x + z * z), twelfth * (x * x + y * y))

    @property
    def reach_m(self) -> float:
        """The distance from the middle of the axle to the farthest corner of the footprint."""
        return max(math.hypot(x, y) for x, y in self.footprint)


class Caster(StrictModel):
    """A ball on which the robot slides without friction."""

    x_m: Coordinate
    """The distance from the axle forward to the middle of the caster."""
    radius_m: Metres


class Drive(StrictModel):
    """A differential drive: two driven wheels on one axle."""

    left: Name
    """The name of the left motor."""
    right: Name
    """The name of the right motor."""
    left_encoder: Name | None = None
    """The name of the left wheel's encoder."""
    right_encoder: Name | None = None
    """The name of the right wheel's encoder."""
    track_m: Metres
    """The distance between the middles of the wheels."""
    wheel_radius_m: Metres
    wheel_width_m: Metres
    wheel_mass_kg: Mass
    """The mass of one wheel."""
    caster: Caster | None = None
    max_acceleration_rad_s2: Annotated[float, Field(ge=0.01, le=1e6)] | None = None
    """The greatest acceleration that the safety layer commands to a wheel. With None there is no limit."""

    @model_validator(mode="after")
    def _require_two_sides(self) -> Drive:
        if self.left == self.right:
            raise InvalidValueError("same-motor", f"left and right are both {self.left!r}; name two motors")
        if (self.left_encoder is None) != (self.right_encoder is None):
            raise InvalidValueError("one-encoder", "one wheel alone has an encoder; name both encoders or neither")
        if self.left_encoder and self.left_encoder == self.right_encoder:
            raise InvalidValueError(
                "same-encoder", f"left and right encoder are both {self.left_encoder!r}; name two encoders"
            )
        return self

    @property
    def wheel_motors(self) -> dict[str, str]:
        """A mapping from each motor or encoder of the drive to the motor of the same wheel, by their names."""
        sides = ((self.left, self.left_encoder), (self.right, self.right_encoder))
        return {device: motor for motor, encoder in sides for device in (motor, encoder) if device}

    @property
    def wheel_moments_kg_m2(self) -> tuple[float, float, float]:
        """The moments of inertia of a wheel, a solid cylinder, about x, its axle and z."""
        radius, width, mass = self.wheel_radius_m, self.wheel_width_m, self.wheel_mass_kg
        across = mass * (3 * radius**2 + width**2) / 12
        return (across, mass * radius**2 / 2, across)

    def wheel_y_m(self, motor: str) -> float:
        """Return the y coordinate of the wheel of a motor, in metres to the left of the robot's middle."""
        return self.track_m / 2 if motor == self.left else -self.track_m / 2

    @property
    def geometry(self) -> DifferentialGeometry:
        return DifferentialGeometry(self.wheel_radius_m, self.track_m)


class Safety(StrictModel):
    """The limits of the safety rules; see `robotcore.safety`."""

    stop_distance_m: Metres = 0.10
    """The distance from an obstacle at which the robot stops."""
    deceleration_m_s2: Annotated[float, Field(ge=0.01, le=100)] = 0.5
    """The deceleration with which the robot can brake for an obstacle."""
    lease_ticks: Annotated[float, Field(ge=1, le=10)] = 2.5
    """A command that is not renewed expires after this many ticks."""
    max_age_s: Annotated[float, Field(ge=0.001, le=3600)] = 1.0
    """The greatest age of a sample. If a sample is older, the app cannot read it."""
    watchdog_s: Annotated[float, Field(ge=0.2, le=3600)] = 3.0
    """The longest duration of one step of the app."""
    answer_s: Annotated[float, Field(ge=0.2, le=3600)] = 1.0
    """The longest duration of a call to a device or a simulator."""
    follow_s: Annotated[float, Field(ge=0.01, le=3600)] = 1.5
    """The longest time for which a wheel's velocity may differ from its command."""
    stuck_m: Metres = 0.5
    """The longest travel, turns included, during which a range sensor may return the same distance."""
    outage_s: Annotated[float, Field(ge=0, le=3600)] = 0.0
    """The longest time for which the robot stands and waits for a lost device. With 0 the run ends at once."""


@dataclass(frozen=True)
class _Origin:
    """The file of a description. All instances compare as equal, so that robots from different files can be equal."""

    file: str | None = field(default=None, compare=False)


class RobotDescription(StrictModel):
    """A robot. Pass ``context={"file": …}`` to `model_validate` to set its ``file``."""

    name: Name
    summary: str = ""
    """One line for lists."""
    body: Body
    drive: Drive | None = None
    """The drive; None for a robot that cannot drive."""
    safety: Safety = Safety()
    devices: Annotated[tuple[DeviceDescription, ...], Field(description="a list of tables: [[devices]]")] = ()
    backends: Annotated[dict[str, dict[str, Any]], BeforeValidator(freeze)] = Field(default_factory=dict)
    """The content of each backend's section in the file, by the backend's name."""
    _origin: _Origin = PrivateAttr(default_factory=_Origin)

    @model_validator(mode="after")
    def _set_origin(self, info: ValidationInfo) -> RobotDescription:
        if info.context and "file" in info.context:
            self._origin = _Origin(info.context["file"])
        return self

    @model_validator(mode="after")
    def _check_names(self) -> RobotDescription:
        require_unique("devices", (device.name for device in self.devices))
        if drive := self.drive:
            motors = {motor.name for motor in self.all_of(MotorDescription)}
            encoders = {encoder.name for encoder in self.all_of(EncoderDescription)}
            _require_devices("drive", (drive.left, drive.right), motors, "motor")
            _require_devices("drive", filter(None, (drive.left_encoder, drive.right_encoder)), encoders, "encoder")
        return self

    @model_validator(mode="after")
    def _check_wheels(self) -> RobotDescription:
        if (drive := self.drive) is None:
            return self
        body, across = self.body, drive.track_m + drive.wheel_width_m
        if drive.wheel_radius_m > body.length_m:
            raise InvalidValueError(
                "wheel-radius-not-in-metres",
                f"a wheel's radius is {drive.wheel_radius_m:g} m, and the body with its wheels {body.length_m:g} m "
                "long; give drive.wheel_radius_m in metres",
            )
        for key in ("track_m", "wheel_width_m"):
            if (given := getattr(drive, key)) > UNIT_ERROR_FACTOR * body.width_m:
                raise InvalidValueError(
                    "wheel-size-not-in-metres",
                    f"drive.{key} is {given:g}, and the body with its wheels {body.width_m:g} m wide; "
                    "give it in metres",
                )
        if across > body.width_m:
            raise InvalidValueError(
                "body-narrower-than-wheels",
                f"the wheels are {across:g} m from outside to outside, the body is {body.width_m:g} m wide; "
                "let body.width_m take in the wheels",
            )
        if not body.front_x_m - body.length_m < 0 < body.front_x_m:
            raise InvalidValueError(
                "axle-not-under-body", "the axle is not under the body; correct body.centre_x_m or body.length_m"
            )
        if body.clearance_m == 0:
            raise InvalidValueError(
                "body-on-floor", "the body lies on the floor; raise body.clearance_m, or leave out [drive]"
            )
        return self

    @property
    def mounts(self) -> dict[str, Mount]:
        """The mount of each sensor that has one, by the sensor's name."""
        mounts = {device.name: getattr(device, "mount", None) for device in self.devices}
        return {sensor: mount for sensor, mount in mounts.items() if isinstance(mount, Mount)}

    @property
    def file(self) -> str | None:
        """The user's file, as the user named it; None for a shipped robot."""
        return self._origin.file

    @property
    def source(self) -> str:
        """The file, or ``robot NAME``, for messages."""
        return self.file or f"robot {self.name}"

    @property
    def range_sensors_ahead(self) -> tuple[RangeSensorDescription, ...]:
        """The range sensors that point ahead. The range guard reads them."""
        return tuple(sensor for sensor in self.all_of(RangeSensorDescription) if sensor.mount.is_ahead)

    def all_of(self, kind: type[DescriptionT]) -> tuple[DescriptionT, ...]:
        """Return the devices of one kind, in the order of the file."""
        return tuple(device for device in self.devices if isinstance(device, kind))

    def with_conditions(self, conditions: Conditions) -> RobotDescription:
        """Return the robot for a simulation: if the conditions have a wheel lag, its wheels have that lag."""
        lag, drive = conditions.wheel_lag_s, self.drive
        if lag is None or drive is None:
            return self
        wheels = (drive.left, drive.right)
        devices = (d.model_copy(update={"lag_s": lag}) if d.name in wheels else d for d in self.devices)
        return self.model_copy(update={"devices": tuple(devices)})

    def first_of(self, kind: type[DescriptionT]) -> DescriptionT | None:
        """Return the first device of one kind, which fills the role; None without such a device."""
        return next(iter(self.all_of(kind)), None)


def _require_devices(table: str, names: Iterable[str], known: set[str], kind: str) -> None:
    for name in names:
        if name not in known:
            raise InvalidValueError(
                "no-such-device",
                f"{table} names the {kind} {name!r}, which is not among the devices; "
                f'add [[devices]] with kind = "{kind}" and that name',
            )
