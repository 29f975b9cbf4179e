"""The base class of drives, and their parts."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from pydantic import Field

from robotcore.description.types import Coordinate, Metres, StrictModel
from robotcore.errors import Mistake
from robotcore.geometry import DifferentialGeometry

Mass = Annotated[float, Field(ge=1e-4, le=1e4)]
"""The mass of a part, in kg, from a tenth of a gram to ten tonnes."""


class Caster(StrictModel):
    """A caster, which simulators model as a ball that slides without friction.

    >>> Caster(x_m=0.1, radius_m=0.012)
    Caster(x_m=0.1, radius_m=0.012)
    """

    x_m: Coordinate
    """The distance from the axle forward to the middle of the caster, in metres."""
    radius_m: Metres


class DriveWheel(NamedTuple):
    """A wheel of a drive. Its middle is at the height of its radius.

    >>> from robotcore.description import load_robot
    >>> left, right = load_robot("rover").drive.wheels
    >>> left.motor, left.y_m > right.y_m
    ('left_motor', True)
    """

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
    """The base class of drives. All wheels of a drive have the same size.

    >>> from robotcore.description import load_robot
    >>> drive = load_robot("freenove-4wd").drive
    >>> drive.kind, drive.left_motors
    ('skid', ('front_left_motor', 'rear_left_motor'))
    >>> drive.geometry.wheel_radius == drive.wheel_radius_m
    True
    """

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


def require_two_encoders(left: str | None, right: str | None) -> None:
    """Raise Mistake unless both wheels have an encoder each, or none has one."""
    if (left is None) != (right is None):
        raise Mistake("only one wheel has an encoder", "Name both encoders or none", kind="one-encoder")
    if left and left == right:
        problem = f"left_encoder and right_encoder are the same encoder {left!r}"
        raise Mistake(problem, "Name two encoders", kind="same-encoder")
