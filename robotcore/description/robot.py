"""The description of a robot: its body, drive, safety limits and devices.

The origin of the robot's frame is on the floor under the centre of the axle: of the rear axle with a drive that steers,
and of all wheels with one that skids. In this frame, x points forward, y left and z up. Keys end in their unit.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, overload

from pydantic import (
    BeforeValidator,
    ConfigDict,
    Field,
    PrivateAttr,
    ValidationInfo,
    model_validator,
)

from robotcore.description.conditions import Conditions
from robotcore.description.devices import AnyDevice, DescriptionT, DeviceDescription, Mount
from robotcore.description.drive import AckermannDrive, Mass, OptionalDrive, TwoWheelDrive
from robotcore.description.types import (
    Colour,
    Coordinate,
    Metres,
    Name,
    StrictModel,
    freeze,
    require_unique,
)
from robotcore.errors import Mistake, UsageError
from robotcore.text import find_nearest, pluralize

GUARD_MARGIN_M = 0.03
"""The range guard stops the robot this far before an obstacle becomes too near for a sensor, in metres."""

MAX_STEERING_RAD = 1.4
"""The greatest angle of a servo that steers, in radians, to either side."""

UNIT_ERROR_FACTOR = 10
"""A wheel's size is refused above this multiple of the body's width, because one of the two is not in metres."""


class Body(StrictModel):
    """The body of a robot, a box. Its length and its width include the wheels.

    >>> body = Body(length_m=0.21, width_m=0.185, height_m=0.11, centre_x_m=0.035, clearance_m=0.018, mass_kg=1.07)
    >>> round(body.front_x_m, 3)
    0.14
    """

    length_m: Metres
    """The distance from the rear to the front, including the wheels, in metres."""
    width_m: Metres
    """The distance from the left side to the right side, including the wheels, in metres."""
    height_m: Metres
    """The distance from the bottom to the top of the body, in metres."""
    centre_x_m: Coordinate = 0.0
    """The distance from the axle forward to the middle of the body, in metres."""
    clearance_m: Annotated[float, Field(ge=0, le=100)]
    """The distance from the floor up to the bottom of the body, in metres."""
    mass_kg: Mass
    """The mass of the body without the wheels, in kg."""
    colour: Colour = (60, 65, 75)

    @property
    def front_x_m(self) -> float:
        """The distance from the axle forward to the front of the body, in metres."""
        return self.centre_x_m + self.length_m / 2

    @property
    def footprint(self) -> tuple[tuple[float, float], ...]:
        """The corners of the body's outline on the floor, counter-clockwise, in the robot's frame, in metres."""
        back, left = self.front_x_m - self.length_m, self.width_m / 2
        return ((self.front_x_m, left), (back, left), (back, -left), (self.front_x_m, -left))

    @property
    def middle_m(self) -> tuple[float, float, float]:
        """The middle and centre of mass of the body, as x, y, z in the robot's frame, in metres."""
        return (self.centre_x_m, 0.0, self.clearance_m + self.height_m / 2)

    @property
    def moments_kg_m2(self) -> tuple[float, float, float]:
        """The moments of inertia of the body, a solid box, about the axes x, y and z through its middle, in kg·m²."""
        x, y, z = self.length_m, self.width_m, self.height_m
        twelfth = self.mass_kg / 12
        return (twelfth * (y * y + z * z), twelfth * (x * x + z * z), twelfth * (x * x + y * y))

    @property
    def reach_m(self) -> float:
        """The distance from the centre of the axle to the farthest corner of the footprint, in metres."""
        return max(math.hypot(x, y) for x, y in self.footprint)


class Safety(StrictModel):
    """The limits of the safety rules in `robotcore.safety`.

    >>> Safety(stop_distance_m=0.15).deceleration_m_s2
    0.5
    """

    stop_distance_m: Metres = 0.10
    """The distance between the robot and an obstacle at which the range guard stops the robot, in metres."""
    deceleration_m_s2: Annotated[float, Field(ge=0.01, le=100)] = 0.5
    """The deceleration that the robot reaches when it brakes, in m/s²."""
    lease_ticks: Annotated[float, Field(ge=1, le=10)] = 2.5
    """The number of ticks after which a command expires if it is not renewed."""
    max_age_s: Annotated[float, Field(ge=0.001, le=3600)] = 1.0
    """The greatest age of a sample, in seconds. Reading an older sample stops the run."""
    watchdog_s: Annotated[float, Field(ge=0.2, le=3600)] = 3.0
    """The time limit for one step of the app, in seconds."""
    answer_s: Annotated[float, Field(ge=0.2, le=3600)] = 1.0
    """The time limit for a call to a device or a simulator, in seconds."""
    follow_s: Annotated[float, Field(ge=0.01, le=3600)] = 1.5
    """The longest time, in seconds, for which a wheel's velocity may differ from its command."""
    stuck_m: Metres = 0.5
    """The longest travel, in metres, during which a range sensor may return the same distance. Turns count too."""
    outage_s: Annotated[float, Field(ge=0, le=3600)] = 0.0
    """The longest time, in seconds, that the robot stops and waits for a lost device. With 0, the run ends at once."""


@dataclass(frozen=True)
class _Origin:
    """The file of a description. All instances are equal, so that descriptions from different files can be equal."""

    file: str | None = field(default=None, compare=False)


class RobotDescription(StrictModel):
    """The description of a robot. ``context={"file": …}`` in a call of `model_validate` sets its ``file``.

    >>> from robotcore.description import load_robot
    >>> robot = load_robot("rover")
    >>> robot
    <RobotDescription rover: differential drive, 2 motors, 2 encoders, 1 range sensor, 1 camera, 1 display>
    >>> robot.first_of("range_sensor").max_range_m, robot.drive.track_m
    (2.0, 0.155)
    """

    model_config: ClassVar[ConfigDict] = ConfigDict(defer_build=True)
    # Packages register the kinds of devices, and their modules import this one.

    name: Name
    summary: str = ""
    """One line about the robot, for `robotcore robots`."""
    body: Body
    drive: OptionalDrive = None
    """The drive; None for a robot that cannot drive."""
    safety: Safety = Safety()
    devices: Annotated[tuple[AnyDevice, ...], Field(description="a list of tables: [[devices]]")] = ()
    backends: Annotated[dict[str, dict[str, Any]], BeforeValidator(freeze)] = Field(default_factory=dict)
    """The contents of the file's sections for backends, by the names of the backends."""
    _origin: _Origin = PrivateAttr(default_factory=_Origin)

    def __repr__(self) -> str:
        kinds = Counter(device.kind.replace("_", " ") for device in self.devices)
        parts = [f"{self.drive.kind} drive"] if self.drive else []
        parts += [pluralize(count, kind) for kind, count in kinds.items()]
        return f"<RobotDescription {self.name}: {', '.join(parts) or 'no devices'}>"

    @model_validator(mode="after")
    def _set_origin(self, info: ValidationInfo) -> RobotDescription:
        if info.context and "file" in info.context:
            self._origin = _Origin(info.context["file"])
        return self

    @model_validator(mode="after")
    def _check_names(self) -> RobotDescription:
        require_unique("devices", (device.name for device in self.devices))
        if drive := self.drive:
            motors = {motor.name for motor in self.all_of("motor")}
            encoders = {encoder.name for encoder in self.all_of("encoder")}
            _require_devices("drive", drive.motors, motors, "motor")
            _require_devices("drive", drive.encoders, encoders, "encoder")
        return self

    @model_validator(mode="after")
    def _check_mounts(self) -> RobotDescription:
        for name in self.mounts:
            self.list_carriers(name)
        return self

    @model_validator(mode="after")
    def _check_wheels(self) -> RobotDescription:
        if (drive := self.drive) is None:
            return self
        body, across = self.body, drive.track_m + drive.wheel_width_m
        if drive.wheel_radius_m > body.length_m:
            length = f"body.length_m with the wheels is only {body.length_m:g} m"
            problem = f"drive.wheel_radius_m is {drive.wheel_radius_m:g} m, but {length}"
            raise Mistake(problem, "Give both in metres", kind="wheel-radius-not-in-metres")
        for key in ("track_m", "wheel_width_m"):
            if (given := getattr(drive, key)) > UNIT_ERROR_FACTOR * body.width_m:
                problem = f"drive.{key} is {given:g} m, but body.width_m with the wheels is only {body.width_m:g} m"
                raise Mistake(problem, "Give both in metres", kind="wheel-size-not-in-metres")
        if across > body.width_m:
            problem = f"the wheels have a width of {across:g} m over all, but body.width_m is only {body.width_m:g} m"
            raise Mistake(problem, "Include the wheels in body.width_m", kind="body-narrower-than-wheels")
        if not body.front_x_m - body.length_m < 0 < body.front_x_m:
            remedy = "Correct body.centre_x_m or body.length_m"
            raise Mistake("the axle is not under the body", remedy, kind="axle-not-under-body")
        rows = len(drive.wheels) // 2
        if rows > 1 and (gap := drive.wheelbase / (rows - 1)) < 2 * drive.wheel_radius_m:
            problem = f"the wheels of a side are {gap:g} m apart, but their diameter is {2 * drive.wheel_radius_m:g} m"
            raise Mistake(problem, "Correct drive.wheelbase_m or drive.wheel_radius_m", kind="wheels-overlap")
        ends = [wheel.x_m + side * drive.wheel_radius_m for wheel in drive.wheels for side in (-1, 1)]
        if drive.wheelbase and not body.front_x_m - body.length_m <= min(ends) <= max(ends) <= body.front_x_m:
            reach = f"from x = {body.front_x_m - body.length_m:g} m to {body.front_x_m:g} m"
            problem = f"the wheels reach from x = {min(ends):g} m to {max(ends):g} m, but the body {reach}"
            remedy = "Include the wheels in body.length_m, and correct body.centre_x_m"
            raise Mistake(problem, remedy, kind="body-shorter-than-wheels")
        if body.clearance_m == 0:
            problem = "body.clearance_m is 0, so the body lies on the floor"
            raise Mistake(problem, "Raise it, or remove [drive]", kind="body-on-floor")
        return self

    @model_validator(mode="after")
    def _check_steering(self) -> RobotDescription:
        if not isinstance(drive := self.drive, AckermannDrive):
            return self
        servos = {servo.name: servo for servo in self.all_of("servo")}
        _require_devices("drive", (drive.steering,), set(servos), "servo")
        servo = servos[drive.steering]
        if not -MAX_STEERING_RAD <= servo.min_angle_rad < 0 < servo.max_angle_rad <= MAX_STEERING_RAD:
            limits = f"from {servo.min_angle_rad:g} rad to {servo.max_angle_rad:g} rad"
            problem = f"the servo {servo.name!r} of [drive] turns {limits}, which is no range for steering"
            remedy = f"Give it a min_angle_rad from {-MAX_STEERING_RAD} to below 0 and a max_angle_rad from above 0 to "
            raise Mistake(problem, f"{remedy}{MAX_STEERING_RAD}", kind="steering-range")
        widest = max(-servo.min_angle_rad, servo.max_angle_rad)
        if drive.to_curvature(widest) * drive.track_m / 2 >= 1:
            problem = f"at {widest:g} rad of {servo.name!r}, the robot would turn about a point between its rear wheels"
            raise Mistake(problem, "Correct its limits, drive.wheelbase_m or drive.track_m", kind="steering-range")
        return self

    def require_two_wheels(self, user: str) -> TwoWheelDrive | None:
        """Return the drive, or None for a robot that cannot drive.

        user: the simulator or the format that has a model of two driven wheels only, for the message.

        Raises UsageError for a drive of another kind.
        """
        if self.drive is None or isinstance(self.drive, TwoWheelDrive):
            return self.drive
        raise UsageError(
            f"{user} has no model of the drive of {self.name!r}, whose kind is {self.drive.kind!r}. Choose another "
            "one, or another robot",
            kind="drive-without-model",
            drive=self.drive.kind,
        )

    @property
    def curvatures(self) -> tuple[float, float]:
        """The curvatures of the sharpest turns to the right and to the left, in 1/m; infinite for turns on the spot."""
        if not isinstance(drive := self.drive, AckermannDrive):
            return -math.inf, math.inf
        servo = next(servo for servo in self.all_of("servo") if servo.name == drive.steering)
        return drive.to_curvature(servo.min_angle_rad), drive.to_curvature(servo.max_angle_rad)

    @property
    def min_turn_radius_m(self) -> float:
        """The radius of the sharpest turn that the robot can make to both sides, in metres; 0 for one on the spot."""
        return 1 / min(map(abs, self.curvatures))

    @property
    def mounts(self) -> dict[str, Mount]:
        """The mounts of the devices that have one, by the names of the devices."""
        mounts = {device.name: getattr(device, "mount", None) for device in self.devices}
        return {name: mount for name, mount in mounts.items() if isinstance(mount, Mount)}

    def list_carriers(self, name: str) -> tuple[str, ...]:
        """Return the names of the servos that turn a device: the one that it is mounted on, the one below that, etc.

        Raises Mistake if the chain has a circle, or a device that is no servo with a mount.
        """
        kinds, mounts, chain = {device.name: device.kind for device in self.devices}, self.mounts, [name]
        while (mount := mounts.get(chain[-1])) and mount.on:
            names, carrier = f"the mount of {chain[-1]!r} names {mount.on!r}", mount.on
            if carrier not in kinds:
                problem = f"{names}, but no device has this name"
                remedy = f'Add [[devices]] with kind = "servo" and name = "{carrier}"'
                if near := find_nearest(carrier, [name for name, kind in kinds.items() if kind == "servo"]):
                    remedy = f"Did you mean {near!r}?"
                raise Mistake(problem, remedy, kind="no-such-device")
            if kinds[carrier] != "servo":
                problem = f"{names}, which is no servo but of the kind {kinds[carrier]!r}"
                raise Mistake(problem, "Name a servo", kind="not-a-servo")
            if carrier in chain:
                problem = f"the mounts make a circle: {' on '.join([*chain, carrier])}"
                raise Mistake(problem, "Mount one of them on the body, without the key on", kind="mounts-in-circle")
            if carrier not in mounts:
                raise Mistake(f"{names}, which has no mount", "Give the servo a mount", kind="servo-without-mount")
            chain.append(carrier)
        return tuple(chain[1:])

    @property
    def file(self) -> str | None:
        """The path of the file as the user wrote it; None for a shipped robot."""
        return self._origin.file

    @property
    def source(self) -> str:
        """The name of the file in messages, or ``robot NAME`` for a shipped robot."""
        return self.file or f"robot {self.name}"

    @property
    def sensors_ahead(self) -> tuple[DeviceDescription, ...]:
        """The sensors that measure the distance ahead, or that a servo may turn ahead. The range guard reads them."""
        return tuple(device for device in self.devices if self._may_look_ahead(device))

    @property
    def guard_distance_m(self) -> float:
        """The distance to an obstacle at which the range guard stops the robot, in metres.

        It is greater than `Safety.stop_distance_m` if a sensor ahead cannot measure an obstacle at that distance.
        """
        nearest = (each.find_nearest_ahead(self.mounts[each.name], self.body.front_x_m) for each in self.sensors_ahead)
        return max([self.safety.stop_distance_m, *(each + GUARD_MARGIN_M for each in nearest if each > 0)])

    def _may_look_ahead(self, device: DeviceDescription) -> bool:
        if (mount := self.mounts.get(device.name)) is None:
            return False
        quarters = range(4) if mount.on else ()
        return any(map(device.looks_ahead, (mount, *(mount.face(each * math.pi / 2) for each in quarters))))

    @overload
    def all_of(self, kind: type[DescriptionT]) -> tuple[DescriptionT, ...]: ...

    @overload
    def all_of(self, kind: str) -> tuple[Any, ...]: ...

    def all_of(self, kind: type[StrictModel] | str) -> tuple[Any, ...]:
        """Return the descriptions of the devices of a kind, in the order of the file.

        kind: the name of the kind, or the class of its descriptions.
        """
        if isinstance(kind, str):
            return tuple(device for device in self.devices if device.kind == kind)
        return tuple(device for device in self.devices if isinstance(device, kind))

    def idealise(self) -> RobotDescription:
        """Return the description of the same robot whose devices have no imperfections."""
        return self.model_copy(update={"devices": tuple(device.idealise() for device in self.devices)})

    def with_conditions(self, conditions: Conditions) -> RobotDescription:
        """Return the description with the wheel lag of the conditions, if they have one."""
        lag, drive = conditions.wheel_lag_s, self.drive
        if lag is None or drive is None:
            return self
        wheels = drive.motors
        devices = (d.model_copy(update={"lag_s": lag}) if d.name in wheels else d for d in self.devices)
        return self.model_copy(update={"devices": tuple(devices)})

    @overload
    def first_of(self, kind: type[DescriptionT]) -> DescriptionT | None: ...

    @overload
    def first_of(self, kind: str) -> Any: ...

    def first_of(self, kind: type[StrictModel] | str) -> Any:
        """Return the description of the first device of a kind, or None if there is none.

        kind: the name of the kind, or the class of its descriptions.
        """
        return next(iter(self.all_of(kind)), None)


def _require_devices(table: str, names: Collection[str], known: set[str], kind: str) -> None:
    for name in names:
        if name not in known:
            problem = f"[{table}] names the {kind} {name!r}, but no {kind} has this name"
            near = find_nearest(name, sorted(known.difference(names)))
            remedy = f"Did you mean {near!r}?" if near else f'Add [[devices]] with kind = "{kind}" and name = "{name}"'
            raise Mistake(problem, remedy, kind="no-such-device")
