"""The drives of robots: two wheels, wheels that skid, and wheels that steer.

A run commands each of them by the velocities of a left and a right wheel on one axle, with the geometry of
`Drive.geometry`. The wheels of a drive that skids or steers are the wheels of a robot with a differential drive that
moves in the same way.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from itertools import zip_longest
from typing import Annotated, Any, Literal, NamedTuple, TypeAlias

from pydantic import BeforeValidator, Field, model_validator

from robotcore.description.types import Coordinate, Metres, Name, StrictModel
from robotcore.errors import Mistake
from robotcore.geometry import DifferentialGeometry

DIFFERENTIAL = "differential"
"""The kind of a drive without the key ``kind``."""

Mass = Annotated[float, Field(ge=1e-4, le=1e4)]
"""The mass of a part, in kg, from a tenth of a gram to ten tonnes."""


class Caster(StrictModel):
    """A caster, which simulators model as a ball that slides without friction."""

    x_m: Coordinate
    """The distance from the axle forward to the middle of the caster, in metres."""
    radius_m: Metres


class DriveWheel(NamedTuple):
    """A wheel of a drive. Its middle is at the height of its radius."""

    name: str
    """The name of the wheel in models: the name of its motor, or a place such as ``front_left``."""
    x_m: float
    """The x coordinate of the middle of the wheel in the robot's frame, in metres."""
    y_m: float
    """The y coordinate of the middle of the wheel in the robot's frame, in metres."""
    motor: str | None
    """The name of the motor that turns the wheel; None for a wheel that rolls freely.

    If a left and a right wheel have the same motor, a differential gear is between them.
    """
    encoder: str | None
    """The name of the encoder that measures the wheel, or the two wheels of its motor; None without one."""
    is_steered: bool = False
    """Whether the servo of the drive turns the wheel about its vertical axis."""


class Drive(StrictModel):
    """The base class of drives. All wheels of a drive have the same size."""

    kind: str
    track_m: Metres
    """The distance between the middles of a left and a right wheel, in metres."""
    wheel_radius_m: Metres
    wheel_width_m: Metres
    wheel_mass_kg: Mass
    """The mass of one wheel, in kg."""
    max_acceleration_rad_s2: Annotated[float, Field(ge=0.01, le=1e6)] | None = None
    """The greatest acceleration that a run commands to a wheel, in rad/s²; None for no limit.

    For a drive that steers, it limits the mean of both rear wheels.
    """

    @property
    def left_motors(self) -> tuple[str, ...]:
        """The names of the motors of the left wheels, from the front to the rear."""
        raise NotImplementedError

    @property
    def right_motors(self) -> tuple[str, ...]:
        """The names of the motors of the right wheels, from the front to the rear."""
        raise NotImplementedError

    @property
    def left_encoders(self) -> tuple[str, ...]:
        """The names of the encoders of the left wheels. The first is on the wheel of the first motor, and so on."""
        raise NotImplementedError

    @property
    def right_encoders(self) -> tuple[str, ...]:
        """The names of the encoders of the right wheels. The first is on the wheel of the first motor, and so on."""
        raise NotImplementedError

    @property
    def wheels(self) -> tuple[DriveWheel, ...]:
        """All wheels, those of the left side first, each side from the front to the rear."""
        raise NotImplementedError

    @property
    def geometry(self) -> DifferentialGeometry:
        """The geometry of a robot with two wheels that moves in the same way."""
        return DifferentialGeometry(self.wheel_radius_m, self.track_m)

    @property
    def wheelbase(self) -> float:
        """The distance between the front and the rear axle, in metres; 0 with one axle."""
        return 0.0

    @property
    def steering_servo(self) -> str | None:
        """The name of the servo that steers; None for a drive that does not steer."""
        return None

    @property
    def motors(self) -> tuple[str, ...]:
        """The names of all motors, without repetition."""
        return tuple(dict.fromkeys((*self.left_motors, *self.right_motors)))

    @property
    def encoders(self) -> tuple[str, ...]:
        """The names of all encoders, without repetition."""
        return tuple(dict.fromkeys((*self.left_encoders, *self.right_encoders)))

    @property
    def motor_by_device(self) -> dict[str, str]:
        """A mapping from the name of each motor and encoder of the drive to the name of the motor on the same wheel."""
        sides = ((self.left_motors, self.left_encoders), (self.right_motors, self.right_encoders))
        return {
            device: motor
            for motors, encoders in sides
            for index, motor in enumerate(motors)
            for device in (motor, *encoders[index : index + 1])
        }

    def find_wheels(self, device: str) -> tuple[DriveWheel, ...]:
        """Return the wheels that a motor turns or an encoder measures: one, or two with a common motor.

        device: the name of the motor or the encoder. The result is empty if it is on no wheel.
        """
        return tuple(wheel for wheel in self.wheels if device in (wheel.motor, wheel.encoder))

    @property
    def wheel_moments_kg_m2(self) -> tuple[float, float, float]:
        """The moments of inertia of a wheel, a solid cylinder, about x, y (its axle) and z, in kg·m²."""
        radius, width, mass = self.wheel_radius_m, self.wheel_width_m, self.wheel_mass_kg
        across = mass * (3 * radius**2 + width**2) / 12
        return (across, mass * radius**2 / 2, across)


class TwoWheelDrive(Drive):
    """A differential drive: two driven wheels on one axle."""

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
        _require_two_encoders(self.left_encoder, self.right_encoder)
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


def _to_tuple(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


Names = Annotated[tuple[Name, ...], Field(description="a list of names in quotes, from the front to the rear")]
Encoders = Annotated[
    tuple[Name, ...], BeforeValidator(_to_tuple), Field(description="a name in quotes, or a list of names")
]


class SkidDrive(Drive):
    """A drive with two or more driven wheels on each side, which skid sideways in a turn.

    Each wheel has a motor, or two wheels of a side have one motor, such as two motors on one channel of a board.

    The origin of the robot's frame is on the floor under the middle of the wheels. All wheels of a side turn at the
    same velocity.
    """

    kind: Literal["skid"]
    left: Names
    """The names of the motors on the left, from the front to the rear."""
    right: Names
    """The names of the motors on the right, from the front to the rear."""
    left_encoder: Encoders = ()
    """The names of encoders on the left. The first is on the wheel of the first motor, and so on."""
    right_encoder: Encoders = ()
    """The names of encoders on the right. The first is on the wheel of the first motor, and so on."""
    wheelbase_m: Metres
    """The distance from the middle of the front wheels to the middle of the rear wheels, in metres."""
    track_factor: Annotated[float, Field(ge=1, le=10, description="the effective track divided by track_m, measured")]
    """The effective track divided by ``track_m``.

    A robot whose wheels skid turns as slowly as one with two wheels that are this much farther apart.
    """

    @model_validator(mode="after")
    def _check_sides(self) -> SkidDrive:
        if len(self.left) != len(self.right) or not self.left:
            problem = f"left names {_count(self.left, 'motor')}, and right {_count(self.right, 'motor')}"
            raise Mistake(problem, "Name the same number on both sides, at least 1", kind="uneven-sides")
        _require_once("motor", (*self.left, *self.right))
        _require_once("encoder", (*self.left_encoder, *self.right_encoder))
        if bool(self.left_encoder) != bool(self.right_encoder):
            problem = "only one side has encoders"
            raise Mistake(problem, "Name encoders on both sides or none", kind="one-encoder")
        for key, encoders in (("left_encoder", self.left_encoder), ("right_encoder", self.right_encoder)):
            if len(encoders) > len(self.left):
                problem = f"{key} names {_count(encoders, 'encoder')}, but the side has {_count(self.left, 'motor')}"
                raise Mistake(problem, "Name at most one encoder a motor", kind="too-many-encoders")
        return self

    @property
    def left_motors(self) -> tuple[str, ...]:
        return self.left

    @property
    def right_motors(self) -> tuple[str, ...]:
        return self.right

    @property
    def left_encoders(self) -> tuple[str, ...]:
        return self.left_encoder

    @property
    def right_encoders(self) -> tuple[str, ...]:
        return self.right_encoder

    @property
    def wheelbase(self) -> float:
        return self.wheelbase_m

    @property
    def geometry(self) -> DifferentialGeometry:
        """The geometry of a robot with two wheels that moves in the same way. Its track is the effective track."""
        return DifferentialGeometry(self.wheel_radius_m, self.track_m * self.track_factor)

    @property
    def wheels(self) -> tuple[DriveWheel, ...]:
        y_m = self.track_m / 2
        left = self._list_side("left", y_m, self.left, self.left_encoder)
        return (*left, *self._list_side("right", -y_m, self.right, self.right_encoder))

    def _list_side(
        self, side: str, y_m: float, motors: tuple[str, ...], encoders: tuple[str, ...]
    ) -> Iterator[DriveWheel]:
        names = motors
        if len(motors) == 1:
            names, motors, encoders = (f"front_{side}", f"rear_{side}"), motors * 2, encoders * 2
        for index, (name, motor, encoder) in enumerate(zip_longest(names, motors, encoders)):
            yield DriveWheel(name, self.wheelbase_m * (0.5 - index / (len(names) - 1)), y_m, motor, encoder)


class AckermannDrive(Drive):
    """A drive with two driven rear wheels and two front wheels that a servo steers.

    The origin of the robot's frame is on the floor under the centre of the rear axle. The rear wheels have one motor
    with a differential gear, ``motor``, or one motor each, ``left`` and ``right``.
    """

    kind: Literal["ackermann"]
    steering: Name
    """The name of the servo that steers.

    Its angle is that of a front wheel in the middle between both, positive to the left.
    """
    motor: Name | None = None
    """The name of the motor of both rear wheels. Its velocity is the mean of theirs."""
    encoder: Name | None = None
    """The name of the encoder of ``motor``."""
    left: Name | None = None
    """The name of the motor of the left rear wheel."""
    right: Name | None = None
    """The name of the motor of the right rear wheel."""
    left_encoder: Name | None = None
    """The name of the left rear wheel's encoder."""
    right_encoder: Name | None = None
    """The name of the right rear wheel's encoder."""
    wheelbase_m: Metres
    """The distance from the rear axle to the front axle, in metres."""

    @model_validator(mode="after")
    def _check_motors(self) -> AckermannDrive:
        if (self.motor is None) == (self.left is None) or (self.left is None) != (self.right is None):
            remedy = "Name one motor of both rear wheels as motor, or the motors of each as left and right"
            raise Mistake("the motors are unclear", remedy, kind="unclear-motors")
        if self.left and self.left == self.right:
            raise Mistake(f"left and right are the same motor {self.left!r}", "Name it as motor", kind="same-motor")
        wrong = self.encoder if self.left else (self.left_encoder or self.right_encoder)
        if wrong:
            fitting = "left_encoder and right_encoder" if self.left else "encoder"
            problem = f"the encoder {wrong!r} does not fit the motors"
            raise Mistake(problem, f"Name it as {fitting}", kind="encoder-without-motor")
        _require_two_encoders(self.left_encoder, self.right_encoder)
        return self

    @property
    def left_motors(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.motor or self.left,)))

    @property
    def right_motors(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.motor or self.right,)))

    @property
    def left_encoders(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.encoder or self.left_encoder,)))

    @property
    def right_encoders(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.encoder or self.right_encoder,)))

    @property
    def steering_servo(self) -> str:
        return self.steering

    @property
    def wheelbase(self) -> float:
        return self.wheelbase_m

    @property
    def wheels(self) -> tuple[DriveWheel, ...]:
        left, right, x_m, y_m = self.motor or self.left, self.motor or self.right, self.wheelbase_m, self.track_m / 2
        return (
            DriveWheel("front_left", x_m, y_m, None, None, is_steered=True),
            DriveWheel("rear_left", 0.0, y_m, left, self.encoder or self.left_encoder),
            DriveWheel("front_right", x_m, -y_m, None, None, is_steered=True),
            DriveWheel("rear_right", 0.0, -y_m, right, self.encoder or self.right_encoder),
        )

    def to_curvature(self, angle_rad: float) -> float:
        """Return the curvature of the path of the rear axle's centre, in 1/m, positive to the left.

        angle_rad: the steering angle, in radians.
        """
        return math.tan(angle_rad) / self.wheelbase_m

    def to_angle_rad(self, curvature: float) -> float:
        """Return the steering angle, in radians, for a curvature of the path in 1/m."""
        return math.atan(curvature * self.wheelbase_m)

    def to_wheel_angles_rad(self, angle_rad: float) -> tuple[float, float]:
        """Return the angles of the left and the right front wheel, in radians, at which no wheel skids sideways.

        angle_rad: the steering angle, that of a front wheel in the middle between both.
        """
        tan, ratio = math.tan(angle_rad), self.track_m / 2 / self.wheelbase_m
        return math.atan(tan / (1 - ratio * tan)), math.atan(tan / (1 + ratio * tan))


def _add_kind(value: Any) -> Any:
    if not isinstance(value, dict) or "kind" in value:
        return value
    if "wheelbase_m" in value:
        raise Mistake("has wheelbase_m, but no kind", 'Add kind = "skid" or kind = "ackermann"', kind="missing-tag")
    return {"kind": DIFFERENTIAL, **value}


AnyDrive: TypeAlias = Annotated[TwoWheelDrive | SkidDrive | AckermannDrive, Field(discriminator="kind")]
OptionalDrive: TypeAlias = Annotated[AnyDrive | None, BeforeValidator(_add_kind)]
"""A drive of any kind, or None. Without the key ``kind``, it is a differential drive."""


def _count(names: tuple[str, ...], noun: str) -> str:
    return f"{len(names)} {noun}{'' if len(names) == 1 else 's'}"


def _require_once(kind: str, names: tuple[str, ...]) -> None:
    if doubles := [name for name, count in Counter(names).items() if count > 1]:
        problem = f"the {kind} {doubles[0]!r} is named twice"
        raise Mistake(problem, f"Name one {kind} a wheel", kind=f"same-{kind}")


def _require_two_encoders(left: str | None, right: str | None) -> None:
    if (left is None) != (right is None):
        raise Mistake("only one wheel has an encoder", "Name both encoders or none", kind="one-encoder")
    if left and left == right:
        problem = f"left_encoder and right_encoder are the same encoder {left!r}"
        raise Mistake(problem, "Name two encoders", kind="same-encoder")
